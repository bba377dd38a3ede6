-- Read the same fields of several jobs, as one string each; false for a job that does not exist.
-- KEYS  jobs
-- ARGV  fields
local found = {}
for place, key in ipairs(KEYS) do
    local values, known = redis.call('HMGET', key, unpack(ARGV)), false
    for i, value in ipairs(values) do
        known = known or value
        values[i] = value or ''
    end
    found[place] = known and table.concat(values, '\n')
end
return found
