-- Add up the sizes of a tenant's blobs; those whose references are gone are removed before the
-- answer is more than a limit, at most once a second.
-- KEYS  1 sizes by the key of the reference, 2 exists for a second after they were removed
-- ARGV  1 limit
local function sum(remove)
    local found = 0
    local entries = redis.call('ZRANGE', KEYS[1], 0, -1, 'WITHSCORES')
    for i = 1, #entries, 2 do
        if remove and redis.call('EXISTS', entries[i]) == 0 then
            redis.call('ZREM', KEYS[1], entries[i])
        else
            found = found + tonumber(entries[i + 1])
        end
    end
    return found
end

local found = sum(false)
if found > tonumber(ARGV[1]) and redis.call('SET', KEYS[2], '', 'NX', 'EX', 1) then
    found = sum(true)
end
return string.format('%.0f', found)
