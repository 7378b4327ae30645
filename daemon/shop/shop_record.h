#pragma once
// What a service knows of the shop's jobs that it took, and what the shop's thread asks it to keep. The
// service's own record decides; the database is told.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "daemon/shop/shop_fit.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Files of a job in the shop's database, bytes: all of them go through its memory.
inline constexpr std::uint64_t kMostShopBytes = 256ull << 20;

/// How far the database was when this machine last saw it.
struct ShopMark {
  std::string shop;          ///< identity of the shop's queue, a UUID; empty: never seen one
  std::uint64_t epoch = 0;   ///< raised by an operator after the database was restored
  std::string epoch_id;      ///< random, so that two epochs of one number are told apart
  std::uint64_t token = 0;   ///< the highest that was seen; each claim raises it
  std::uint64_t serial = 0;  ///< how often the database has taken an acceptance or a report of this machine
  bool operator==(const ShopMark&) const = default;
};

/// Who may speak of a job: the last claim of it wins.
struct ShopTicket {
  std::string job;  ///< UUID
  std::uint64_t epoch = 0, token = 0;
  bool operator==(const ShopTicket&) const = default;
};

struct ShopFile {
  std::string sha256;  ///< 64 hexadecimal digits
  std::uint64_t bytes = 0;
  bool operator==(const ShopFile&) const = default;
};

/// A job as it was claimed.
struct ShopJob {
  ShopTicket ticket;
  std::uint64_t number = 0;  ///< for people
  std::string name;
  bool program = false;         ///< else a job file and its part
  std::vector<ShopFile> files;  ///< program; or job, part
  bool operator==(const ShopJob&) const = default;
};

/// What became of a job here.
struct ShopReport {
  ShopJob job;
  std::uint64_t version = 0;  ///< each change of it raises this
  std::string state, note;    ///< the spool's words; "removed"
  std::uint64_t blocks = 0, executed = 0;
};

/// From when on the machine was what (a word of shop_live.h).
struct ShopState {
  std::uint64_t at = 0;  ///< ms since 1970, by the service's clock
  std::string state;
  bool operator==(const ShopState&) const = default;
};

/// The service's record, as of one moment.
struct LocalShop {
  std::string machine;  ///< this service's identity, a UUID
  std::string name;     ///< of the machine, for people; empty: its profile's
  ShopOffer offer;
  ShopMark mark;
  std::vector<ShopJob> claimed;      ///< whose acceptance the database has not confirmed
  std::vector<ShopJob> accepted;     ///< confirmed; their files are still to come
  std::vector<ShopReport> reports;   ///< that the database does not have yet: some of them, the oldest first
  std::vector<std::string> waiting;  ///< jobs in the spool that have not begun and are still this machine's
  bool wants = false;                ///< there is room for one more
  std::string status;                ///< of the service, for people
  std::string live = "{}";           ///< what the machine is at, as live_json has it
  std::vector<ShopState> states;     ///< that the database does not have yet: some of them, the oldest first
};

/// The service's side, called by the shop's thread. Each is durable when it returns without an error; an
/// error (kIo: the spool) means that nothing has changed, and is tried again.
struct ShopLedger {
  std::function<Result<LocalShop>()> read;
  std::function<Result<void>(const ShopMark&)> remember;
  /// The claim, and the mark that goes with it. False: this machine has the job already, which keeps its
  /// state, has the new ticket and is reported again.
  std::function<Result<bool>(const ShopJob&, const ShopMark&)> claim;
  /// The database has the acceptance, as this machine's `serial`: the job is this machine's.
  std::function<Result<void>(const std::string& job, std::uint64_t serial)> confirm;
  /// The claim came to nothing; the job may be offered again.
  std::function<Result<void>(const std::string& job)> drop;
  /// Into the spool, as a submission is; the descriptors stay the caller's. kInput: its files are
  /// refused.
  std::function<Result<void>(const ShopJob&, const std::vector<int>& files)> arrive;
  /// Its files cannot be had or are refused: "spoiled", which is reported. It never was here.
  std::function<Result<void>(const std::string& job, const std::string& why)> spoil;
  std::function<Result<void>(const std::string& job, std::uint64_t version, std::uint64_t serial)> told;
  /// The database has the states up to this time.
  std::function<Result<void>(std::uint64_t at)> told_states;
  /// Another machine has it, or the database knows more of it than this record: it must not begin here.
  std::function<Result<void>(const std::string& job, const std::string& why)> overrule;
  /// All is reported once more: the database may have lost it.
  std::function<Result<void>()> retell;
  /// A file without a name in the spool's folder; -1: none can be made.
  std::function<int()> scratch;
  std::function<void(bool bad, const std::string& text)> log;
  /// How it stands with the database, for people.
  std::function<void(const std::string&)> show;
};

/// What the database seems to be to who remembers `mark`.
enum class ShopTrust : std::uint8_t {
  kSame,      ///< as far as it was, or further
  kNew,       ///< never seen, another shop, or an operator raised the epoch: all is told to it again
  kRestored,  ///< behind what this machine has seen: nothing is taken until an operator raises the epoch
};
/// Properties: 1 A lower epoch, a lower token or serial of the same epoch, or another identity of the same
/// epoch is kRestored. 2 Another shop, or a higher epoch, is kNew.
ShopTrust judge_shop(const ShopMark& mark, const ShopMark& found);

/// 8-4-4-4-12 lower-case hexadecimal digits.
bool is_uuid(const std::string& text);
/// Random, of version 4.
std::string make_uuid();

}  // namespace tiltfeed::daemon
