-- Store the result of a chunk, once.
-- KEYS  4 results of the stage
-- ARGV  1 stage, 2 chunk, 3 result, 4 seconds, 5 ttl
local counts = redis.call('HMGET', KEYS[2], 'stage', 'count', 'base', 'share')
if counts[1] ~= ARGV[1] or redis.call('HEXISTS', KEYS[4], ARGV[2]) == 1 then
    return 0
end
redis.call('HSET', KEYS[4], ARGV[2], ARGV[3])
redis.call('HDEL', KEYS[3], ARGV[2])
local done = redis.call('HINCRBY', KEYS[2], 'done', 1)
redis.call('HINCRBYFLOAT', KEYS[2], 'seconds:' .. ARGV[1], ARGV[4])
redis.call('EXPIRE', KEYS[2], ARGV[5])
redis.call('EXPIRE', KEYS[4], ARGV[5])
-- Rounded like base + share at the end of the stage, so that progress never decreases.
redis.call('HSET', KEYS[1], 'fraction', math.min(counts[3] + counts[4] * (done / counts[2]), 1))
return 1
