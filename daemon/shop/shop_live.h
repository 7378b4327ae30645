#pragma once
// What a machine is at, as the shop's database has it: for the page that shows all machines.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "daemon/shop/pg_connection.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The words of a machine's state: they go to the database as they are.
inline constexpr const char* kShopIdle = "idle";
inline constexpr const char* kShopRunning = "running";  ///< a program is executed
inline constexpr const char* kShopHeld = "held";        ///< a program is held, or stands before a tool change
inline constexpr const char* kShopSetup = "setup";      ///< a command of `tiltfeed machine` moves it
inline constexpr const char* kShopFault = "fault";      ///< a run was cut off, and nobody has settled that
inline constexpr const char* kShopOff = "off";          ///< its service ended in order
inline constexpr const char* kShopUnknown = "unknown";  ///< its service died; nobody saw what the machine did
bool is_shop_state(const std::string& word);

/// Longest text of it, bytes.
inline constexpr std::size_t kMostLiveJson = 3000;
/// A machine whose service has told nothing for longer is not known to be at anything, s: a service tells at
/// least every 10 s.
inline constexpr double kShopSilent = 30.0;

struct ShopLive {
  std::string state = kShopUnknown;
  std::string job;  ///< the name of what is on the machine; empty: nothing
  std::string alarm;
  std::uint64_t blocks = 0, executed = 0;
  double remaining_seconds = -1.0;  ///< by machine time; below 0: not known
  std::uint64_t clock = 0;          ///< of the service's host, ms since 1970
  bool operator==(const ShopLive&) const = default;
};

/// Texts are cut off at 40 (job) and 300 (alarm) bytes.
std::string live_json(const ShopLive& live);
/// Of a text that anybody may have written; what of it is missing or no such value is left as it is by
/// default.
ShopLive parse_live(const std::string& json);

/// How long a machine was what.
struct ShopUsage {
  std::string state;
  double day = 0.0, week = 0.0;  ///< s, of the last 24 hours and 7 days
};
/// By machine. Property: a state holds until the next one, the last one as long as the machine was heard;
/// what lies between that and now is told by none.
Result<std::map<std::string, std::vector<ShopUsage>>> view_usage(const ShopAsk& ask);

}  // namespace tiltfeed::daemon
