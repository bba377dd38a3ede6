-- Remove entries from a listing unless their records exist (again).
-- KEYS  1 listing, then the record of each entry
-- ARGV  entries
-- Returns how many were removed.
local removed = 0
for place, entry in ipairs(ARGV) do
    if redis.call('EXISTS', KEYS[place + 1]) == 0 then
        removed = removed + redis.call('ZREM', KEYS[1], entry)
    end
end
return removed
