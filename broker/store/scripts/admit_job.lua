-- Count a new job towards its caller's quota of queued jobs.
-- KEYS  1 jobs queued by the caller
-- ARGV  1 job, 2 now, 3 limit (0 for none), 4 prefix of job keys, 5 seconds a reservation is valid
-- Returns 0 if the caller has as many jobs queued as it may have.
local limit = tonumber(ARGV[3])
local state = redis.call('HGET', ARGV[4] .. ARGV[1], 'state')
if state or redis.call('ZSCORE', KEYS[1], ARGV[1]) then
    return 1
end
if limit > 0 and redis.call('ZCARD', KEYS[1]) >= limit then
    -- Remove reservations of processes that died before they stored their job.
    for _, job in ipairs(redis.call('ZRANGEBYSCORE', KEYS[1], '-inf', ARGV[2] - ARGV[5])) do
        if redis.call('HGET', ARGV[4] .. job, 'state') ~= 'queued' then
            redis.call('ZREM', KEYS[1], job)
        end
    end
    if redis.call('ZCARD', KEYS[1]) >= limit then
        return 0
    end
end
redis.call('ZADD', KEYS[1], ARGV[2], ARGV[1])
return 1
