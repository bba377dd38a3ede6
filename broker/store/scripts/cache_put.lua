-- Cache a blob. Blobs unused for too long are dropped, then the least recently used until all fit.
-- KEYS  3 blob
-- ARGV  3 now, 4 oldest last use that is kept, 5 budget in bytes, 6 blob
-- Returns 0 if the blob alone exceeds the budget.
drop(ARGV[1])
for _, name in ipairs(redis.call('ZRANGEBYSCORE', KEYS[1], '-inf', ARGV[4])) do
    drop(name)
end
local size = #ARGV[6]
if size > tonumber(ARGV[5]) then
    return 0
end
while tonumber(redis.call('HGET', KEYS[2], 'total') or '0') + size > tonumber(ARGV[5]) do
    local oldest = redis.call('ZRANGE', KEYS[1], 0, 0)
    if #oldest == 0 then
        redis.call('HSET', KEYS[2], 'total', 0)
        break
    end
    drop(oldest[1])
end
redis.call('SET', KEYS[3], ARGV[6])
redis.call('ZADD', KEYS[1], ARGV[3], ARGV[1])
redis.call('HSET', KEYS[2], ARGV[1], size)
redis.call('HINCRBY', KEYS[2], 'total', size)
return 1
