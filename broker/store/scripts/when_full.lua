-- Prelude of the scripts that a full Redis must not refuse: they keep little, and free more. Redis
-- refuses a command that may take memory, but not after another write of the same script. (The flag
-- `allow-oom` would need Redis 7.)
-- KEYS  1 a hash
redis.call('HDEL', KEYS[1], '')
