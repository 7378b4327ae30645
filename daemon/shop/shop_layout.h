#pragma once
// The tables and functions of a shop's queue in PostgreSQL, and what is asked of them.

#include <string>
#include <vector>

namespace tiltfeed::daemon {

/// Kept in the database; a program refuses another.
inline constexpr int kShopLayout = 3;

/// One statement each, in this order, in one transaction. Fails where the schema tiltfeed is there.
const std::vector<std::string>& shop_layout();
/// Likewise, from an earlier layout to this one; empty: no such layout. Services that know another layout
/// stop taking jobs, and say so.
std::vector<std::string> shop_upgrade(const std::string& from);

/// States of a job that are the database's own; all others are the spool's words, told by a machine.
/// open: for whoever fits. claimed: offered to a machine, until its lease ends. accepted: a machine's own.
/// held: an operator decides. withdrawn: by whoever submitted it.

/// $1 machine, $2 name, $3 what it has, $4 status, then what it remembers: $5 shop ("" for none), $6 epoch,
/// $7 epoch's identity, $8 token, $9 serial, $10 what the machine is at (shop_live.h). Row: layout, shop,
/// epoch, its identity, token, serial, why it is halted ("" for not), whether the machine has told its part
/// since the server's start. Halts the queue where the database is behind what is remembered.
inline constexpr const char* kShopHello =
    "SELECT * FROM tiltfeed.hello($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)";
/// $1 machine, $2 times as an array, ms since 1970, $3 states as an array. The same again changes nothing.
inline constexpr const char* kShopStates = "SELECT tiltfeed.tell_states($1, $2, $3)";
/// $1 machine: it has told its part.
inline constexpr const char* kShopTold = "UPDATE tiltfeed.machines SET told = true WHERE id = $1";
/// $1 after which number. Rows: id, number, needs (cut off). Jobs that can be claimed, the oldest first.
inline constexpr const char* kShopOpen =
    "SELECT id, number, left(needs, 8193) FROM tiltfeed.jobs WHERE (state = 'open' OR (state = 'claimed' AND "
    "lease < now())) AND number > $1 ORDER BY number LIMIT 32";
/// How many rows of it are a full page.
inline constexpr std::size_t kShopPage = 32;
/// $1 machine, $2 ids that fit as an array, $3 epoch, $4 its identity. At most one row: id, epoch, token,
/// number, name, program, sha256, bytes, sha256 and bytes of the part.
inline constexpr const char* kShopClaim = "SELECT * FROM tiltfeed.claim($1, $2, $3, $4)";
/// $1 machine, $2 id, $3 epoch, $4 token. Row: accepted, halted or lost; serial.
inline constexpr const char* kShopAccept = "SELECT * FROM tiltfeed.accept($1, $2, $3, $4)";
/// $1 machine, $2 id, $3 epoch, $4 token, $5 why: a claim that cannot be taken is held.
inline constexpr const char* kShopRefuse =
    "UPDATE tiltfeed.jobs SET state = 'held', lease = NULL, note = $5, changed = now() WHERE machine = $1 "
    "AND "
    "id = $2 AND epoch = $3 AND token = $4 AND state = 'claimed'";
/// $1 machine, $2 id, $3 epoch, $4 token, $5 version, $6 state, $7 note, $8 blocks, $9 executed, $10 name,
/// $11 program, $12 begun, $13 sha256. Row: taken or overruled; why; serial.
inline constexpr const char* kShopReport =
    "SELECT * FROM tiltfeed.report($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)";
/// $1 ids as an array, $2 machine. Rows: id, state: those of them that are another's now.
inline constexpr const char* kShopGone =
    "SELECT id, state FROM tiltfeed.jobs WHERE id = ANY ($1) AND machine IS DISTINCT FROM $2";
/// $1 id, $2 file (0, 1), $3 piece. Row: its bytes in hexadecimal digits.
inline constexpr const char* kShopPiece =
    "SELECT encode(bytes, 'hex') FROM tiltfeed.pieces WHERE job = $1 AND file = $2 AND piece = $3 AND "
    "octet_length(bytes) <= 262144";
inline constexpr std::size_t kShopPieceBytes = 262144;
/// $1 machine: it ends in order; nobody waits for it, and others plan what it planned for them.
inline constexpr const char* kShopBye =
    "WITH back AS (UPDATE tiltfeed.plans SET state = 'open', helper = NULL, lease = NULL, tries = tries - 1 "
    "WHERE helper = $1 AND state = 'taken') UPDATE tiltfeed.machines SET away = true, status = '', plans = "
    "'' WHERE id = $1";
inline constexpr const char* kShopListen = "LISTEN tiltfeed_jobs";
inline constexpr const char* kShopNotify = "SELECT pg_notify('tiltfeed_jobs', '')";

}  // namespace tiltfeed::daemon
