#include "daemon/command/shop_watch.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "daemon/command/shop_view.h"
#include "daemon/shop/pg_connection.h"
#include "daemon/shop/shop_layout.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;
using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{3000}, kAtLeast{500}, kAgain{3000};
constexpr std::chrono::seconds kUsageAge{60};

/// What changes by news alone: a page counts the seconds itself.
std::string news_of(const ShopView& view) {
  ordered_json json = ordered_json::parse(view_json(view));
  json.erase("now");
  for (ordered_json& machine : json["machines"]) machine.erase("silent_seconds");
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

class ShopWatch {
 public:
  explicit ShopWatch(const std::string& file) : file_(file) {}

  /// False: nobody hears it any more.
  bool tell(const char* state, const std::string& error) const {
    const ordered_json line = {{"version", version_}, {"state", state}, {"error", error}, {"now", now_}};
    std::cout << line.dump(-1, ' ', true, ordered_json::error_handler_t::replace) << std::endl;
    return std::cout.good();
  }
  Result<void> look(const ShopAsk& ask) {
    Result<ShopView> view = view_shop(ask, ShopPick::kLastDay);
    if (!view) return tl::unexpected<Error>(view.error());
    if (!usage_due_ || steady_clock::now() > *usage_due_) {
      auto usage = view_usage(ask);
      if (!usage) return tl::unexpected<Error>(usage.error());
      usage_ = std::move(*usage);
      usage_due_ = steady_clock::now() + kUsageAge;
    }
    add_usage(usage_, *view);
    now_ = view->now;
    return keep(news_of(*view));
  }

 private:
  Result<void> keep(std::string news) {
    if (news == news_) return {};
    const std::string beside = file_ + ".new";
    std::ofstream out(beside, std::ios::binary);
    out << news;
    out.close();
    std::error_code failed;
    if (out.good()) std::filesystem::rename(beside, file_, failed);
    if (!out.good() || failed) return fail(Code::kIo, file_ + ": cannot be written");
    news_ = std::move(news);
    ++version_;
    return {};
  }

  std::string file_, news_;
  std::uint64_t version_ = 0;
  std::int64_t now_ = 0;
  std::map<std::string, std::vector<ShopUsage>> usage_;
  std::optional<steady_clock::time_point> usage_due_;
};

/// Until the connection is lost or nobody hears (kCancelled).
Result<void> follow_shop(PgConnection& database, ShopWatch& watch) {
  const ShopAsk ask = [&](const std::string& sql, const std::vector<PgValue>& values) {
    return database.ask(sql, values);
  };
  if (const auto heard = database.ask(kShopListen); !heard) return tl::unexpected<Error>(heard.error());
  for (;;) {
    if (Result<void> seen = watch.look(ask); !seen) return seen;
    if (!watch.tell("up", "")) return fail(Code::kCancelled, "nobody hears it");
    std::this_thread::sleep_for(kAtLeast);
    if (const Result<bool> waited = database.wait(-1, kLook - kAtLeast); !waited)
      return tl::unexpected<Error>(waited.error());
  }
}

}  // namespace

Result<void> watch_shop(const std::string& url, const std::string& file) {
  if (const Result<void> good = check_pg_url(url); !good) return good;
  ShopWatch watch(file);
  for (;;) {
    Result<PgConnection> database = PgConnection::connect(url, -1);
    const Result<void> ended =
        database ? follow_shop(*database, watch) : tl::unexpected<Error>(database.error());
    if (ended.error().code == Code::kCancelled) return {};
    if (ended.error().code == Code::kIo) return ended;
    if (!watch.tell("lost", ended.error().message)) return {};
    std::this_thread::sleep_for(kAgain);
  }
}

}  // namespace tiltfeed::daemon
