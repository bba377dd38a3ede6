-- Prelude of the scripts on the chunks of a job that is done in time slices.
-- KEYS  1 job, 2 stage and counts, 3 holders of the chunks
local job = redis.call('HMGET', KEYS[1], 'state', 'cancel')
if job[1] ~= 'running' or job[2] then
    return {'ended', '', -1}
end
