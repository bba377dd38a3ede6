-- Remove an entry from a listing unless its record exists (again).
-- KEYS  1 listing, 2 record
-- ARGV  1 entry
if redis.call('EXISTS', KEYS[2]) == 1 then
    return 0
end
return redis.call('ZREM', KEYS[1], ARGV[1])
