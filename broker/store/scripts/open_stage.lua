-- Open the next stage, once.
-- KEYS  4 results of the new stage
-- ARGV  1 previous stage, 2 new stage, 3 number of chunks, 4 share of the progress,
--       5 size of a chunk, 6 ttl, then numbers and results of chunks that are known
if redis.call('HGET', KEYS[2], 'stage') ~= ARGV[1] then
    return 0
end
local previous = redis.call('HMGET', KEYS[2], 'base', 'share')
local base = tonumber(previous[1]) + tonumber(previous[2])
for i = 7, #ARGV, 2 do
    redis.call('HSET', KEYS[4], ARGV[i], ARGV[i + 1])
end
redis.call('EXPIRE', KEYS[4], ARGV[6])
redis.call('HSET', KEYS[2], 'stage', ARGV[2], 'next', 0, 'count', ARGV[3],
    'done', redis.call('HLEN', KEYS[4]), 'base', base, 'share', ARGV[4], 'size', ARGV[5])
redis.call('DEL', KEYS[3])
redis.call('EXPIRE', KEYS[2], ARGV[6])
redis.call('HSET', KEYS[1], 'stage', ARGV[2], 'fraction', math.min(base, 1))
return 1
