-- Return the sum of the sizes of what a tenant keeps; what has expired is removed before the answer
-- is more than a limit. Redis waits meanwhile: the sum is kept for a minute, and the removal, 7 us an
-- entry, is not repeated for 100 us an entry.
-- KEYS  1 sizes by key
-- ARGV  1 limit
local function add_up(remove)
    local found = 0
    local entries = redis.call('ZRANGE', KEYS[1], 0, -1, 'WITHSCORES')
    for i = 1, #entries, 2 do
        if remove and redis.call('EXISTS', entries[i]) == 0 then
            redis.call('ZREM', KEYS[1], entries[i])
        else
            found = found + tonumber(entries[i + 1])
        end
    end
    redis.call('SET', KEYS[1] .. ':sum', string.format('%.0f', found), 'EX', 60)
    return found
end

local found = tonumber(redis.call('GET', KEYS[1] .. ':sum') or nil) or add_up(false)
local pause = math.ceil(redis.call('ZCARD', KEYS[1]) / 10)
if found > tonumber(ARGV[1]) and pause > 0
    and redis.call('SET', KEYS[1] .. ':counted', '', 'NX', 'PX', pause) then
    found = add_up(true)
end
return string.format('%.0f', found)
