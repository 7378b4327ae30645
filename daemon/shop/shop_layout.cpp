#include "daemon/shop/shop_layout.h"

#include "daemon/shop/shop_plan_layout.h"

namespace tiltfeed::daemon {

namespace {

/// `incarnation`: when the server's process began: another after every restart, failover and restore. `told`:
/// the machine has reported all that it knows since then.
constexpr const char* kShopTable = R"sql(CREATE TABLE tiltfeed.shop (
  one boolean PRIMARY KEY DEFAULT true CHECK (one),
  layout integer NOT NULL,
  shop uuid NOT NULL DEFAULT gen_random_uuid(),
  epoch bigint NOT NULL DEFAULT 1,
  epoch_id uuid NOT NULL DEFAULT gen_random_uuid(),
  token bigint NOT NULL DEFAULT 0,
  halted text NOT NULL DEFAULT '',
  incarnation text NOT NULL DEFAULT '',
  began timestamptz NOT NULL DEFAULT now()))sql";

constexpr const char* kMachinesTable = R"sql(CREATE TABLE tiltfeed.machines (
  id uuid PRIMARY KEY,
  name text NOT NULL,
  offer text NOT NULL,
  status text NOT NULL,
  incarnation text NOT NULL,
  token bigint NOT NULL,
  serial bigint NOT NULL DEFAULT 0,
  told boolean NOT NULL DEFAULT false,
  away boolean NOT NULL DEFAULT false,
  seen timestamptz NOT NULL,
  live text NOT NULL DEFAULT '{}'))sql";
constexpr const char* kLiveColumn =
    "ALTER TABLE tiltfeed.machines ADD COLUMN live text NOT NULL DEFAULT '{}'";

/// From when on a machine was what, by its own clock, ms since 1970.
constexpr const char* kStatesTable = R"sql(CREATE TABLE tiltfeed.states (
  machine uuid NOT NULL,
  at bigint NOT NULL,
  state text NOT NULL,
  PRIMARY KEY (machine, at)))sql";

/// Told again it changes nothing. What is older than 35 days goes, but the state that the machine had then.
constexpr const char* kTellStates =
    R"sql(CREATE FUNCTION tiltfeed.tell_states(in_machine uuid, in_at bigint[], in_states text[])
RETURNS void LANGUAGE sql AS $$
  INSERT INTO tiltfeed.states (machine, at, state) SELECT in_machine, a, left(s, 20) FROM unnest(in_at, in_states) AS told (a, s)
    ON CONFLICT (machine, at) DO NOTHING;
  DELETE FROM tiltfeed.states WHERE machine = in_machine AND at < (SELECT max(s.at) FROM tiltfeed.states s
    WHERE s.machine = in_machine AND s.at <= extract(epoch FROM now() - interval '35 days') * 1000);
$$)sql";

constexpr const char* kJobsTable = R"sql(CREATE TABLE tiltfeed.jobs (
  id uuid PRIMARY KEY,
  number bigint GENERATED ALWAYS AS IDENTITY UNIQUE,
  name text NOT NULL,
  program boolean NOT NULL,
  needs text NOT NULL,
  sha256 text NOT NULL,
  bytes bigint NOT NULL,
  part_sha256 text NOT NULL DEFAULT '',
  part_bytes bigint NOT NULL DEFAULT 0,
  submitted timestamptz NOT NULL DEFAULT now(),
  submitter text NOT NULL DEFAULT session_user,
  state text NOT NULL DEFAULT 'open',
  note text NOT NULL DEFAULT '',
  machine uuid,
  epoch bigint NOT NULL DEFAULT 0,
  token bigint NOT NULL DEFAULT 0,
  version bigint NOT NULL DEFAULT 0,
  lease timestamptz,
  blocks bigint NOT NULL DEFAULT 0,
  executed bigint NOT NULL DEFAULT 0,
  changed timestamptz NOT NULL DEFAULT now()))sql";

constexpr const char* kPiecesTable = R"sql(CREATE TABLE tiltfeed.pieces (
  job uuid NOT NULL REFERENCES tiltfeed.jobs ON DELETE CASCADE,
  file smallint NOT NULL,
  piece integer NOT NULL,
  bytes bytea NOT NULL,
  PRIMARY KEY (job, file, piece)))sql";

constexpr const char* kHello =
    R"sql(CREATE FUNCTION tiltfeed.hello(in_machine uuid, in_name text, in_offer text,
  in_status text, in_shop text, in_epoch bigint, in_epoch_id text, in_token bigint, in_serial bigint, in_live text)
RETURNS TABLE (out_layout integer, out_shop uuid, out_epoch bigint, out_epoch_id uuid, out_token bigint,
  out_serial bigint, out_halted text, out_told boolean) LANGUAGE plpgsql AS $$
DECLARE
  born text := extract(epoch FROM pg_postmaster_start_time())::text;
  stored bigint;
BEGIN
  UPDATE tiltfeed.shop SET incarnation = born, began = now() WHERE incarnation <> born;
  SELECT serial INTO stored FROM tiltfeed.machines WHERE id = in_machine;
  UPDATE tiltfeed.shop SET halted = 'the database is behind what ' || in_name || ' has seen of it: it was restored, '
      'or its standby had not got the last'
    WHERE halted = '' AND shop::text = in_shop AND (epoch < in_epoch OR (epoch = in_epoch AND
      (epoch_id::text <> in_epoch_id OR token < in_token OR coalesce(stored, 0) < in_serial)));
  INSERT INTO tiltfeed.machines AS m (id, name, offer, status, incarnation, token, seen, live)
    VALUES (in_machine, in_name, in_offer, in_status, born, in_token, now(), in_live)
    ON CONFLICT (id) DO UPDATE SET name = in_name, offer = in_offer, status = in_status, live = in_live,
      told = m.told AND m.incarnation = born, incarnation = born, token = in_token, away = false, seen = now();
  RETURN QUERY SELECT s.layout, s.shop, s.epoch, s.epoch_id, s.token, m.serial, s.halted, m.told
    FROM tiltfeed.shop s, tiltfeed.machines m WHERE m.id = in_machine;
END $$)sql";

/// Nothing is given while the queue is halted, in another epoch than the machine knows, or in the first 20 s
/// after a restart of the server as long as a machine that did not leave in order has not told its part: it
/// may know more than the database.
constexpr const char* kClaim =
    R"sql(CREATE FUNCTION tiltfeed.claim(in_machine uuid, in_fits uuid[], in_epoch bigint,
  in_epoch_id uuid)
RETURNS TABLE (out_id uuid, out_epoch bigint, out_token bigint, out_number bigint, out_name text, out_program boolean,
  out_sha256 text, out_bytes bigint, out_part_sha256 text, out_part_bytes bigint) LANGUAGE plpgsql AS $$
DECLARE
  picked uuid;
  given bigint;
BEGIN
  SELECT id INTO picked FROM tiltfeed.jobs
    WHERE id = ANY (in_fits) AND (state = 'open' OR (state = 'claimed' AND lease < now()))
    ORDER BY number LIMIT 1 FOR UPDATE SKIP LOCKED;
  IF NOT FOUND THEN
    RETURN;
  END IF;
  UPDATE tiltfeed.shop s SET token = s.token + 1
    WHERE s.halted = '' AND s.epoch = in_epoch AND s.epoch_id = in_epoch_id
      AND s.incarnation = extract(epoch FROM pg_postmaster_start_time())::text
      AND (s.began < now() - interval '20 seconds' OR NOT EXISTS (SELECT 1 FROM tiltfeed.machines m
        WHERE (m.incarnation <> s.incarnation OR NOT m.told) AND NOT m.away))
    RETURNING s.token INTO given;
  IF NOT FOUND THEN
    RETURN;
  END IF;
  RETURN QUERY UPDATE tiltfeed.jobs j SET state = 'claimed', machine = in_machine, epoch = in_epoch, token = given,
      version = 0, lease = now() + interval '30 seconds', note = '', changed = now()
    WHERE j.id = picked
    RETURNING j.id, j.epoch, j.token, j.number, left(j.name, 200), j.program, left(j.sha256, 65), j.bytes,
      left(j.part_sha256, 65), j.part_bytes;
END $$)sql";

constexpr const char* kAccept =
    R"sql(CREATE FUNCTION tiltfeed.accept(in_machine uuid, in_id uuid, in_epoch bigint,
  in_token bigint)
RETURNS TABLE (out_verdict text, out_serial bigint) LANGUAGE plpgsql AS $$
DECLARE
  counted bigint := 0;
BEGIN
  IF EXISTS (SELECT 1 FROM tiltfeed.shop WHERE halted <> '') THEN
    RETURN QUERY SELECT 'halted', 0::bigint;
    RETURN;
  END IF;
  UPDATE tiltfeed.jobs SET state = 'accepted', lease = NULL, changed = now()
    WHERE id = in_id AND machine = in_machine AND epoch = in_epoch AND token = in_token
      AND state IN ('claimed', 'accepted');
  IF NOT FOUND THEN
    RETURN QUERY SELECT 'lost', 0::bigint;
    RETURN;
  END IF;
  UPDATE tiltfeed.machines SET serial = serial + 1 WHERE id = in_machine RETURNING serial INTO counted;
  RETURN QUERY SELECT 'accepted', counted;
END $$)sql";

constexpr const char* kReport =
    R"sql(CREATE FUNCTION tiltfeed.report(in_machine uuid, in_id uuid, in_epoch bigint,
  in_token bigint, in_version bigint, in_state text, in_note text, in_blocks bigint, in_executed bigint, in_name text,
  in_program boolean, in_begun boolean, in_sha256 text)
RETURNS TABLE (out_verdict text, out_why text, out_serial bigint) LANGUAGE plpgsql AS $$
DECLARE
  j tiltfeed.jobs%ROWTYPE;
  counted bigint := 0;
  why text := '';
BEGIN
  -- The database may have been restored to a time before the job.
  INSERT INTO tiltfeed.jobs (id, name, program, needs, sha256, bytes, state) VALUES
    (in_id, in_name, in_program, '{}', in_sha256, 0, 'held') ON CONFLICT (id) DO NOTHING;
  SELECT * INTO j FROM tiltfeed.jobs WHERE id = in_id FOR UPDATE;
  IF (j.epoch, j.token) > (in_epoch, in_token)
      OR ((j.epoch, j.token) = (in_epoch, in_token) AND j.machine IS DISTINCT FROM in_machine) THEN
    SELECT 'it is ' || j.state || ' at ' || m.name INTO why FROM tiltfeed.machines m WHERE m.id = j.machine;
    why := coalesce(why, 'it is ' || j.state || ' there');
    IF in_begun THEN
      UPDATE tiltfeed.jobs SET state = CASE WHEN state IN ('open', 'claimed') THEN 'held' ELSE state END,
          note = left('it was ' || in_state || ' at ' || coalesce((SELECT name FROM tiltfeed.machines
            WHERE id = in_machine), 'another machine') || ' too; ' || note, 500), changed = now() WHERE id = in_id;
    END IF;
    RETURN QUERY SELECT 'overruled', why, 0::bigint;
    RETURN;
  END IF;
  IF (j.epoch, j.token) = (in_epoch, in_token) AND j.version > in_version THEN
    RETURN QUERY SELECT 'overruled', 'this machine has told of it that it is ' || j.state, 0::bigint;
    RETURN;
  END IF;
  UPDATE tiltfeed.jobs SET machine = in_machine, epoch = in_epoch, token = in_token, version = in_version,
      state = in_state, note = in_note, blocks = in_blocks, executed = in_executed, lease = NULL, changed = now()
    WHERE id = in_id;
  UPDATE tiltfeed.shop SET token = in_token WHERE epoch = in_epoch AND token < in_token;
  UPDATE tiltfeed.machines SET serial = serial + 1 WHERE id = in_machine RETURNING serial INTO counted;
  RETURN QUERY SELECT 'taken', '', counted;
END $$)sql";

}  // namespace

const std::vector<std::string>& shop_layout() {
  static const std::vector<std::string> statements = [] {
    std::vector<std::string> all = {
        "CREATE SCHEMA tiltfeed",
        kShopTable,
        "INSERT INTO tiltfeed.shop (layout) VALUES (" + std::to_string(kShopLayout) + ")",
        kMachinesTable,
        kJobsTable,
        "CREATE INDEX jobs_open ON tiltfeed.jobs (number) WHERE state IN ('open', 'claimed')",
        kPiecesTable,
        kHello,
        kClaim,
        kAccept,
        kReport,
        kStatesTable,
        kTellStates,
    };
    all.insert(all.end(), shop_plan_layout().begin(), shop_plan_layout().end());
    return all;
  }();
  return statements;
}

std::vector<std::string> shop_upgrade(const std::string& from) {
  std::vector<std::string> all;
  if (from == "1")
    all = {kLiveColumn,
           "DROP FUNCTION tiltfeed.hello(uuid, text, text, text, text, bigint, text, bigint, bigint)", kHello,
           kStatesTable, kTellStates};
  else if (from != "2")
    return all;
  all.insert(all.end(), shop_plan_layout().begin(), shop_plan_layout().end());
  all.push_back("UPDATE tiltfeed.shop SET layout = " + std::to_string(kShopLayout));
  return all;
}

}  // namespace tiltfeed::daemon
