-- Cancel a queued job at once, and a job done in time slices, which is its own runner.
-- The runner of any other running job is asked to stop.
-- ARGV  2 now, 3 record's ttl
if state == 'queued' or (state == 'running' and runner == ARGV[1]) then
    finish(state, 'cancelled', ARGV[2], ARGV[3])
    return 'cancelled'
end
if state == 'running' then
    redis.call('HSETNX', KEYS[1], 'cancel', ARGV[2])
end
return state
