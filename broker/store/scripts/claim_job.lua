-- Start a queued job. A job that is repeated after a crash keeps its first start time.
-- ARGV  2 runner, 3 now
-- Returns the state and the runner that holds the job.
if state ~= 'queued' then
    return {state, runner}
end
move('queued', 'running')
redis.call('HSET', KEYS[1], 'runner', ARGV[2])
redis.call('HSETNX', KEYS[1], 'started', ARGV[3])
return {'running', ARGV[2]}
