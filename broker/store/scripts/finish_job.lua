-- End a job that this runner holds. The result is stored before the state can be seen.
-- ARGV  2 runner, 3 now, 4 record's ttl, 5 end state, 6 error or '', 7 reference to the result's
--       blob or '', 8 result's ttl
-- Returns the state and the runner that holds, or held, the job; no runner if it has another result.
if state ~= 'running' or runner ~= ARGV[2] then
    -- Several processes run a job that is its own runner. A call that is sent again, because its
    -- reply was lost, finds its own result.
    local other = ARGV[7] ~= '' and redis.call('HGET', KEYS[10], 'blob') ~= ARGV[7]
    return {state, not other and runner}
end
if ARGV[7] ~= '' then
    redis.call('DEL', KEYS[10])
    redis.call('HSET', KEYS[10], 'blob', ARGV[7])
    redis.call('EXPIRE', KEYS[10], ARGV[8])
    -- The reference is the blob's token, its size and its digest.
    hold(KEYS[11], KEYS[10], tonumber(string.match(ARGV[7], ' (%d+) ')))
end
if ARGV[6] ~= '' then
    set_error(ARGV[6])
end
if ARGV[5] == 'succeeded' then
    redis.call('HSET', KEYS[1], 'stage', 'done', 'fraction', '1')
end
finish('running', ARGV[5], ARGV[3], ARGV[4])
return {ARGV[5], runner}
