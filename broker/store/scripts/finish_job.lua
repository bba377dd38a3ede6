-- End a job that this runner holds. The result is stored before the state can be seen.
-- ARGV  2 runner, 3 now, 4 record's ttl, 5 end state, 6 error or '', 7 result's ttl,
--       8 reference to the result's blob or '', 9 to that of the arrays or '', 10 summary or ''
-- Returns the state and the runner that holds, or held, the job; no runner if it has another result.
if state ~= 'running' or runner ~= ARGV[2] then
    -- Several processes run a job that is its own runner. A call that is sent again, because its
    -- reply was lost, finds its own result.
    local other = ARGV[8] ~= '' and redis.call('HGET', KEYS[10], 'blob') ~= ARGV[8]
    return {state, not other and runner}
end
for key, reference in pairs({[KEYS[10]] = ARGV[8], [KEYS[13]] = ARGV[9]}) do
    if reference ~= '' then
        redis.call('DEL', key)
        redis.call('HSET', key, 'blob', reference)
        redis.call('EXPIRE', key, ARGV[7])
        -- The reference is the blob's token, its size and its digest.
        hold(KEYS[11], key, tonumber(string.match(reference, ' (%d+) ')))
    end
end
if ARGV[10] ~= '' then
    redis.call('SET', KEYS[14], ARGV[10], 'EX', ARGV[7])
end
if ARGV[6] ~= '' then
    set_error(ARGV[6])
end
if ARGV[5] == 'succeeded' then
    redis.call('HSET', KEYS[1], 'stage', 'done', 'fraction', '1')
end
finish('running', ARGV[5], ARGV[3], ARGV[4])
return {ARGV[5], runner}
