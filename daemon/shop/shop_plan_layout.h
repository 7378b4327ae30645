#pragma once
// Tables of the orders of planning in the shop's database, and what is asked of them.

#include <string>
#include <vector>

namespace tiltfeed::daemon {

/// One statement each: what layout 3 adds to layout 2.
const std::vector<std::string>& shop_plan_layout();

/// States of an order. open: for whoever helps. taken: a machine's own, until its lease ends, 60 s. done:
/// with files. failed: with a note. Files of an order: 0 job, 1 part, 2 profile, under token 0; 3 program, 4
/// map, 5 CL file, 6 report, under the token of who made them. An order that is taken, or that has been taken
/// three times and given back by nobody, goes to nobody else.

/// $1 machine, $2 the version with which it would plan for another now; "": it would not.
inline constexpr const char* kPlanOffer =
    "UPDATE tiltfeed.machines SET plans = $2 WHERE id = $1 AND plans <> $2";
/// $1 machine, $2 version. A row: a machine that is heard would plan for this one.
inline constexpr const char* kPlanHelpers =
    "SELECT 1 FROM tiltfeed.machines WHERE plans = $2 AND plans <> '' AND id <> $1 AND NOT away AND seen > "
    "now() - interval '30 seconds' LIMIT 1";
/// $1 machine, $2 version. A row: likewise, and it has no order, so it would begin at its next turn.
inline constexpr const char* kPlanIdle =
    "SELECT 1 FROM tiltfeed.machines m WHERE m.plans = $2 AND m.plans <> '' AND m.id <> $1 AND NOT m.away "
    "AND "
    "m.seen > now() - interval '30 seconds' AND NOT EXISTS (SELECT 1 FROM tiltfeed.plans p WHERE p.helper = "
    "m.id AND p.state = 'taken' AND p.lease >= now()) LIMIT 1";
/// $1 id, $2 machine, $3 name, $4 version. The same again changes nothing. A row: it is new.
inline constexpr const char* kPlanAsk =
    "INSERT INTO tiltfeed.plans (id, asker, name, version) VALUES ($1, $2, $3, $4) ON CONFLICT (id) DO "
    "NOTHING RETURNING id";
/// $1 id, $2 file, $3 sha256, $4 bytes; and its pieces: $1 id, $2 file, $3 piece, $4 bytes.
inline constexpr const char* kPlanGiveFile =
    "INSERT INTO tiltfeed.plan_files (plan, token, file, sha256, bytes) VALUES ($1, 0, $2, $3, $4)";
inline constexpr const char* kPlanGivePiece =
    "INSERT INTO tiltfeed.plan_pieces (plan, token, file, piece, bytes) VALUES ($1, 0, $2, $3, $4)";
/// $1 machine. Rows: id, state (one whose lease is over is open), who plans it, token, percent, stage, note,
/// version of who planned it, the digests that it was planned from.
inline constexpr const char* kPlanSeen =
    "SELECT p.id, CASE WHEN p.state = 'taken' AND p.lease < now() THEN 'open' ELSE p.state END, "
    "coalesce(left(m.name, 100), ''), p.token, p.percent, p.stage, p.note, p.planned_by, p.planned_from FROM "
    "tiltfeed.plans p LEFT JOIN tiltfeed.machines m ON m.id = p.helper WHERE p.asker = $1 ORDER BY p.number "
    "LIMIT 100";
/// $1 id, $2 machine: its asker needs it no more.
inline constexpr const char* kPlanDrop = "DELETE FROM tiltfeed.plans WHERE id = $1 AND asker = $2";
/// Of orders whose asker was not heard for a day.
inline constexpr const char* kPlanForget =
    "DELETE FROM tiltfeed.plans p WHERE NOT EXISTS (SELECT 1 FROM tiltfeed.machines m WHERE m.id = p.asker "
    "AND m.seen > now() - interval '1 day')";
/// $1 machine, $2 its version. At most one row: id, token, name, who asks. Of an asker that is heard.
inline constexpr const char* kPlanTake =
    "UPDATE tiltfeed.plans o SET state = 'taken', helper = $1, token = o.token + 1, tries = o.tries + 1, "
    "percent = 0, stage = '', lease = now() + interval '60 seconds', changed = now() WHERE o.id = (SELECT "
    "p.id FROM tiltfeed.plans p JOIN tiltfeed.machines m ON m.id = p.asker WHERE p.version = $2 AND p.asker "
    "<> $1 AND (p.state = 'open' OR (p.state = 'taken' AND p.lease < now())) AND p.tries < 3 AND NOT m.away "
    "AND m.seen > now() - interval '30 seconds' ORDER BY p.number LIMIT 1 FOR UPDATE OF p SKIP LOCKED) "
    "RETURNING o.id, o.token, o.name, (SELECT left(m.name, 100) FROM tiltfeed.machines m WHERE m.id = "
    "o.asker)";
/// $1 id, $2 token. Rows: file, sha256, bytes.
inline constexpr const char* kPlanFiles =
    "SELECT file, left(sha256, 65), bytes FROM tiltfeed.plan_files WHERE plan = $1 AND token = $2 ORDER BY "
    "file LIMIT 8";
/// $1 id, $2 token, $3 file, $4 piece. Row: its bytes in hexadecimal digits.
inline constexpr const char* kPlanPiece =
    "SELECT encode(bytes, 'hex') FROM tiltfeed.plan_pieces WHERE plan = $1 AND token = $2 AND file = $3 AND "
    "piece = $4 AND octet_length(bytes) <= 262144";
/// $1 machine, $2 id, $3 token, $4 percent, $5 stage. A row: the order is still this machine's.
inline constexpr const char* kPlanKeep =
    "UPDATE tiltfeed.plans SET lease = now() + interval '60 seconds', percent = $4, stage = left($5, 100) "
    "WHERE helper = $1 AND id = $2 AND token = $3 AND state = 'taken' RETURNING id";
/// $1 machine, $2 id, $3 token: it plans that no more, and that is nobody's fault.
inline constexpr const char* kPlanBack =
    "UPDATE tiltfeed.plans SET state = 'open', helper = NULL, lease = NULL, tries = tries - 1, changed = "
    "now() WHERE helper = $1 AND id = $2 AND token = $3 AND state = 'taken'";
/// $1 machine: what it took in an earlier life.
inline constexpr const char* kPlanBackAll =
    "UPDATE tiltfeed.plans SET state = 'open', helper = NULL, lease = NULL, changed = now() WHERE helper = "
    "$1 "
    "AND state = 'taken'";
/// $1 machine, $2 id, $3 token, $4 why.
inline constexpr const char* kPlanFail =
    "UPDATE tiltfeed.plans SET state = 'failed', lease = NULL, note = left($4, 500), changed = now() WHERE "
    "helper = $1 AND id = $2 AND token = $3 AND state = 'taken'";
/// $1 machine, $2 id, $3 token: what it gave before the connection was lost.
inline constexpr const char* kPlanUnmade =
    "DELETE FROM tiltfeed.plan_files f USING tiltfeed.plans p WHERE p.helper = $1 AND p.id = $2 AND p.token "
    "= $3 AND p.state = 'taken' AND f.plan = p.id AND f.token = p.token";
/// $1 machine, $2 id, $3 token, $4 file, $5 sha256, $6 bytes. A row: the order is still this machine's.
inline constexpr const char* kPlanMadeFile =
    "INSERT INTO tiltfeed.plan_files (plan, token, file, sha256, bytes) SELECT p.id, p.token, $4::smallint, "
    "$5::text, $6::bigint FROM tiltfeed.plans p WHERE p.helper = $1 AND p.id = $2 AND p.token = $3 AND "
    "p.state = 'taken' RETURNING file";
/// $1 machine, $2 id, $3 token, $4 file, $5 piece, $6 bytes; likewise. The lease goes on.
inline constexpr const char* kPlanMadePiece =
    "WITH mine AS (UPDATE tiltfeed.plans SET lease = now() + interval '60 seconds' WHERE helper = $1 AND id "
    "= $2 AND token = $3 AND state = 'taken' RETURNING id, token) INSERT INTO tiltfeed.plan_pieces (plan, "
    "token, file, piece, bytes) SELECT id, token, $4::smallint, $5::integer, $6::bytea FROM mine RETURNING "
    "piece";
/// $1 machine, $2 id, $3 token, $4 version, $5 the digests that it was planned from.
inline constexpr const char* kPlanDone =
    "UPDATE tiltfeed.plans SET state = 'done', lease = NULL, percent = 100, planned_by = $4, planned_from = "
    "$5, changed = now() WHERE helper = $1 AND id = $2 AND token = $3 AND state = 'taken'";

}  // namespace tiltfeed::daemon
