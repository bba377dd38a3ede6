-- Rename the candidate to the upload of a shape. A transaction whose reply was lost is sent again,
-- and RENAME would then fail.
-- KEYS  1 candidate, 2 upload
if redis.call('EXISTS', KEYS[1]) == 1 then
    redis.call('RENAME', KEYS[1], KEYS[2])
end
