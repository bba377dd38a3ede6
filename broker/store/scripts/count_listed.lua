-- Count the entries of a listing; those whose records have expired are removed before the answer
-- is more than a limit. Redis waits meanwhile, 7 us an entry: it is not repeated for 100 us an entry.
-- KEYS  1 listing
-- ARGV  1 prefix of the records' keys, 2 limit
local count = redis.call('ZCARD', KEYS[1])
local pause = math.ceil(count / 10)
if count <= tonumber(ARGV[2]) or pause == 0
    or not redis.call('SET', KEYS[1] .. ':counted', '', 'NX', 'PX', pause) then
    return count
end
for _, entry in ipairs(redis.call('ZRANGE', KEYS[1], 0, -1)) do
    if redis.call('EXISTS', ARGV[1] .. entry) == 0 then
        redis.call('ZREM', KEYS[1], entry)
    end
end
return redis.call('ZCARD', KEYS[1])
