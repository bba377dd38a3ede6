-- Record a job's progress, which never decreases.
-- KEYS  1 job
-- ARGV  1 runner, 2 stage, 3 fraction
-- Returns 0 if the job is cancelled or no longer held by this runner.
local job = redis.call('HMGET', KEYS[1], 'state', 'runner', 'cancel', 'fraction')
if job[1] ~= 'running' or job[2] ~= ARGV[1] or job[3] then
    return 0
end
-- Several processes report that of a batch, and one that has counted earlier may come later.
if tonumber(ARGV[3]) >= tonumber(job[4]) then
    redis.call('HSET', KEYS[1], 'stage', ARGV[2], 'fraction', ARGV[3])
end
return 1
