-- Count a new job towards the quotas of its caller's queued jobs, and of its tenant's jobs; or a
-- validation towards those of validations.
-- KEYS  1 jobs queued by the caller, 2 jobs of the tenant that have not ended
-- ARGV  1 job, 2 now, 3 limit of the caller (0 for none), 4 limit of the tenant (0 for none),
--       5 prefix of job keys, 6 seconds a reservation is valid, 7 seconds after the last admission
--       for which places are counted
-- Returns 0 if the caller has as many jobs as it may have, -1 if the tenant has, else 1.
local function state_of(job)
    return redis.call('HGET', ARGV[5] .. job, 'state')
end

local function is_full(key, limit, counts)
    if limit == 0 or redis.call('ZCARD', key) < limit then
        return false
    end
    -- Remove reservations of processes that died before they stored their job, and jobs of expired
    -- records.
    for _, job in ipairs(redis.call('ZRANGEBYSCORE', key, '-inf', ARGV[2] - ARGV[6])) do
        if not counts[state_of(job) or 'none'] then
            redis.call('ZREM', key, job)
        end
    end
    return redis.call('ZCARD', key) >= limit
end

if state_of(ARGV[1]) or redis.call('ZSCORE', KEYS[1], ARGV[1]) then
    return 1
end
if is_full(KEYS[1], tonumber(ARGV[3]), {queued = true}) then
    return 0
end
if is_full(KEYS[2], tonumber(ARGV[4]), {queued = true, running = true}) then
    return -1
end
for _, key in ipairs(KEYS) do
    redis.call('ZADD', key, ARGV[2], ARGV[1])
    -- Without a limit nobody removes the reservations of processes that died.
    redis.call('EXPIRE', key, ARGV[7])
end
return 1
