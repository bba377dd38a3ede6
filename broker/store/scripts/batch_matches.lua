-- Find out how far a batch is. All of its matches before the place `next` were queued. A set names
-- those of them that may not have ended, and those that were queued before their turn.
-- KEYS  1 hash with `next`, 2 set of matches
-- ARGV  1 prefix of job keys, 2 batch, 3 number of its matches, 4 ttl
-- Returns next, how many have ended, then ids and states of those that are queued or running.
local ENDED = {succeeded = true, failed = true, cancelled = true}
local count, next = tonumber(ARGV[3]), tonumber(redis.call('HGET', KEYS[1], 'next') or 0)
-- Whoever queued a match may not have recorded it: an earlier version, or a process that died.
while next < count do
    local match = ARGV[2] .. '-' .. next + 1
    if redis.call('EXISTS', ARGV[1] .. match .. ':trace') == 0 then
        break
    end
    redis.call('SADD', KEYS[2], match)
    next = next + 1
end
local ended, live = next, {}
for _, match in ipairs(redis.call('SMEMBERS', KEYS[2])) do
    local state = redis.call('HGET', ARGV[1] .. match, 'state')
    local had_its_turn = tonumber(string.match(match, '%d+$')) <= next
    if not state or ENDED[state] then
        if had_its_turn then
            redis.call('SREM', KEYS[2], match)
        else
            ended = ended + 1
        end
    else
        if had_its_turn then
            ended = ended - 1
        end
        live[#live + 1] = match
        live[#live + 1] = state
    end
end
redis.call('HSET', KEYS[1], 'next', next)
for _, key in ipairs(KEYS) do
    redis.call('EXPIRE', key, ARGV[4])
end
return {next, ended, unpack(live)}
