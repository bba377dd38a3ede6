-- Queue a job again whose process was lost, or fail it after too many losses.
-- ARGV  2 now, 3 record's ttl, 4 losses allowed, 5 error, 6 runner that was lost, '' for whichever
--       holds the job, 7 name of this loss, '' if it has none: a loss is counted once
if state ~= 'queued' and state ~= 'running' then
    return state
end
if state == 'running' and ARGV[6] ~= '' and runner ~= ARGV[6] then
    return state
end
if redis.call('HEXISTS', KEYS[1], 'cancel') == 1 then
    finish(state, 'cancelled', ARGV[2], ARGV[3])
    return 'cancelled'
end
if ARGV[7] ~= '' and redis.call('HGET', KEYS[1], 'loss') == ARGV[7] then
    return state
end
if redis.call('HINCRBY', KEYS[1], 'losses', 1) > tonumber(ARGV[4]) then
    set_error(ARGV[5])
    finish(state, 'failed', ARGV[2], ARGV[3])
    return 'failed'
end
redis.call('HSET', KEYS[1], 'loss', ARGV[7])
requeue(state)
return 'queued'
