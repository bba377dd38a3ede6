-- Cache a blob. Blobs unused for too long are dropped, then the least recently used until all fit.
-- KEYS  3 blob
-- ARGV  3 now, 4 oldest last use that is kept, 5 budget in bytes, 6 blob
-- Returns 0 if the blob alone exceeds the budget; the others are kept within it nevertheless.
drop(ARGV[1])
for _, name in ipairs(redis.call('ZRANGEBYSCORE', KEYS[1], '-inf', ARGV[4])) do
    drop(name)
end
local size, budget = #ARGV[6], tonumber(ARGV[5])
local left = size > budget and budget or budget - size
while tonumber(redis.call('HGET', KEYS[2], 'total') or '0') > left do
    local oldest = redis.call('ZRANGE', KEYS[1], 0, 0)
    if #oldest == 0 then
        redis.call('HSET', KEYS[2], 'total', 0)
        break
    end
    drop(oldest[1])
end
if size > budget then
    return 0
end
redis.call('SET', KEYS[3], ARGV[6])
redis.call('ZADD', KEYS[1], ARGV[3], ARGV[1])
redis.call('HSET', KEYS[2], ARGV[1], size)
redis.call('HINCRBY', KEYS[2], 'total', size)
return 1
