-- Record that a webhook is being delivered, unless its job has expired: HSET would create a
-- record that never expires.
-- KEYS  1 job
-- ARGV  1 delivery job, 2 number of the attempt
if redis.call('EXISTS', KEYS[1]) == 0 then
    return 0
end
redis.call('HSET', KEYS[1], 'delivery_job', ARGV[1], 'attempts', ARGV[2])
return 1
