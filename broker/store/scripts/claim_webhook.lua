-- Postpone a webhook that is due, for the process that queues its delivery.
-- KEYS  1 webhooks
-- ARGV  1 job, 2 when the webhook was due, 3 when it is due again
-- Returns 0 if another process was first.
local due = redis.call('ZSCORE', KEYS[1], ARGV[1])
if not due or tonumber(due) ~= tonumber(ARGV[2]) then
    return 0
end
redis.call('ZADD', KEYS[1], ARGV[3], ARGV[1])
return 1
