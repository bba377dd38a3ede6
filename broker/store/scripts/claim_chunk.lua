-- Claim a chunk whose holder was lost, or else the next unclaimed one.
-- ARGV  1 time slice, 2 its runner, 3 prefix of job keys, 4 prefix of the stages' results
-- Returns claim status, stage, number of the chunk.
local function holds(holder)
    local slice, runner = string.match(holder, '^(.-)|(.*)$')
    local record = redis.call('HMGET', ARGV[3] .. slice, 'state', 'runner')
    return record[1] == 'running' and record[2] == runner
end

local me = ARGV[1] .. '|' .. ARGV[2]
local counts = redis.call('HMGET', KEYS[2], 'stage', 'next', 'count', 'done')
local stage, next, count = counts[1], tonumber(counts[2]), tonumber(counts[3])
local holders = redis.call('HGETALL', KEYS[3])
for i = 1, #holders, 2 do
    if holders[i + 1] == me or not holds(holders[i + 1]) then
        redis.call('HSET', KEYS[3], holders[i], me)
        redis.call('HINCRBY', KEYS[2], 'taken', 1)
        return {'part', stage, tonumber(holders[i])}
    end
end
while next < count and redis.call('HEXISTS', ARGV[4] .. stage, next) == 1 do
    next = next + 1
end
redis.call('HSET', KEYS[2], 'next', next < count and next + 1 or next)
if next < count then
    redis.call('HSET', KEYS[3], next, me)
    redis.call('HINCRBY', KEYS[2], 'taken', 1)
    return {'part', stage, next}
end
return {tonumber(counts[4]) >= count and 'done' or 'busy', stage, -1}
