-- Record the outcome of a webhook's delivery, unless its job has expired.
-- KEYS  1 job, 2 webhooks
-- ARGV  1 job's id, 2 delivery, 3 when the webhook is due again or ''
local exists = redis.call('EXISTS', KEYS[1]) == 1
if exists then
    redis.call('HSET', KEYS[1], 'delivery', ARGV[2])
end
if exists and ARGV[3] ~= '' then
    redis.call('ZADD', KEYS[2], ARGV[3], ARGV[1])
else
    redis.call('ZREM', KEYS[2], ARGV[1])
end
