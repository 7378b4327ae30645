#pragma once
// The shop's queue and all its machines: `tiltfeed shop` as processes of their own, one that looks, and one
// for each order.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "desk/api/part_work.h"
#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

struct ShopOptions {
  std::string url;       ///< of the queue; empty: this desk shows no shop
  std::string tiltfeed;  ///< the program
  std::string folder;    ///< where its file is kept
};

/// Properties: what is shown is as old as it says; what the database does not tell is told as `lost`, with
/// the last that was seen beside it. A process that ends is started again.
class ShopWork {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kAgain{3}, kSilent{30};

  ShopWork(ShopOptions options, Teller tell, std::function<void(std::uint64_t, const Reply&)> finish);

  bool is_shown() const { return !options_.url.empty(); }
  /// JSON: null, or `version`, `state` (asked, up, lost) and `error`.
  std::string describe() const;
  /// JSON: that, `now` (the database's clock when it was asked last), `age` (seconds since then) and `shop`.
  Reply view(Time now) const;
  /// A reply that comes later. `command`: release, withdraw or raise; `job` 0: none.
  Reply order(std::uint64_t ticket, const std::string& command, std::uint64_t job);
  /// What a person has to know before the epoch is raised.
  std::string raise_text() const;

  std::vector<int> descriptors() const;
  /// False: it is another's descriptor.
  bool hear(int descriptor, Time now);
  void look(Time now);
  /// Milliseconds after which look() is due; -1: never.
  int patience_ms(Time now) const;

 private:
  struct Order {
    std::uint64_t ticket = 0;
    std::vector<std::string> words;
  };
  std::string file() const { return options_.folder + "/shop.json"; }
  void take_line(const std::string& line, Time now);
  void set(const std::string& state, const std::string& error);
  void next_order();

  ShopOptions options_;
  Teller tell_;
  std::function<void(std::uint64_t, const Reply&)> finish_;
  std::optional<ChildProcess> watch_, acting_;
  std::deque<Order> orders_;  ///< the first is in work
  std::string state_ = "asked", error_;
  std::string words_;                      ///< the last line of the process that is none of its own
  std::uint64_t version_ = 0, shown_ = 0;  ///< of the file; `shown_`: what the page is told, never used twice
  std::int64_t now_ = 0;
  std::string seen_ = "null";  ///< the newest content of the file
  std::optional<Time> heard_;  ///< when the database answered last
  std::optional<Time> said_;   ///< when the process said something
  Time due_{};                 ///< when it is started again
};

}  // namespace tiltfeed::desk
