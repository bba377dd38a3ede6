-- Count an attempt to deliver a webhook, unless its job has expired: HSET would create a record that
-- never expires.
-- KEYS  1 job
-- ARGV  1 number of the attempt
if redis.call('EXISTS', KEYS[1]) == 1 then
    redis.call('HSET', KEYS[1], 'attempts', ARGV[1])
end
