#include "daemon/command/shop_session.h"

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "config/service_config.h"
#include "daemon/command/interrupt.h"

namespace tiltfeed::daemon {

void ShopPlace::add_options(CLI::App& command) {
  command.add_option(
      "--shop", url,
      "the shop's queue, postgresql://USER@HOST/DATABASE?passfile=FILE, no password in it; else that "
      "of --config, else $TILTFEED_SHOP");
  command.add_option("--config", config, "a service's file (YAML), whose queue is meant");
}

Result<std::string> ShopPlace::find() const {
  if (!url.empty()) return url;
  if (!config.empty()) {
    const Result<config::ServiceConfig> service = config::load_service_config(config);
    if (!service) return tl::unexpected<Error>(service.error());
    if (service->queue.url.empty()) return fail(Code::kUsage, config + ": has no queue of a shop");
    return service->queue.url;
  }
  const char* const named = std::getenv("TILTFEED_SHOP");
  if (named != nullptr && *named != '\0') return std::string(named);
  return fail(Code::kUsage, "name the shop's queue with --shop URL or --config FILE, or set TILTFEED_SHOP");
}

Result<void> in_shop(const ShopPlace& place, bool again,
                     const std::function<Result<void>(const ShopAsk&)>& work) {
  const Result<std::string> url = place.find();
  if (!url) return tl::unexpected<Error>(url.error());
  const PromptEnd prompt_end;
  for (bool once_more = again;; once_more = false) {
    Result<PgConnection> database = PgConnection::connect(*url, -1);
    if (!database) return fail(database.error().code, "the shop's queue: " + database.error().message);
    Result<void> done = work([&](const std::string& sql, const std::vector<PgValue>& values) {
      return database->ask(sql, values);
    });
    if (done || done.error().code != Code::kLink || !once_more) return done;
  }
}

}  // namespace tiltfeed::daemon
