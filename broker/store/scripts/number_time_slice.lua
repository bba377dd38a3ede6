-- Return the number of a new time slice, from 2 (the first is queued with the job); 0 if the job
-- has ended.
-- KEYS  1 stage and counts
if redis.call('EXISTS', KEYS[1]) == 0 then
    return 0
end
return redis.call('HINCRBY', KEYS[1], 'turns', 1) + 1
