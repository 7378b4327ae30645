#include "daemon/command/shop_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "daemon/command/command.h"
#include "daemon/command/shop_session.h"
#include "daemon/command/shop_view.h"
#include "daemon/command/shop_watch.h"
#include "daemon/shop/shop_orders.h"

namespace tiltfeed::daemon {

using nlohmann::ordered_json;

struct ShopCommand::Options {
  CLI::App *shop = nullptr, *init = nullptr, *list = nullptr, *release = nullptr, *withdraw = nullptr,
           *raise = nullptr, *watch = nullptr;
  ShopPlace place;
  std::string into;
  std::uint64_t job = 0;
  bool as_json = false, all = false, yes = false;

  int tell(const Result<void>& done, const ordered_json& answer, const std::string& text) const;
  int run_list() const;
  int run_init() const;
  int run_raise() const;
  int run_take_back(bool open) const;
};

ShopCommand::ShopCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.shop = app.add_subcommand("shop",
                              "the shop's queue in PostgreSQL, from which machines take the jobs that fit");
  o.shop->require_subcommand(1);
  const auto command = [&](const char* name, const char* text) {
    CLI::App* const one = o.shop->add_subcommand(name, text);
    o.place.add_options(*one);
    one->add_flag("--json", o.as_json, "print one JSON object");
    return one;
  };
  o.init = command(
      "init",
      "make the queue's tables in an empty database, or bring those of an earlier version up to date");
  o.list = command("list", "machines, and jobs that are not done; why no machine fits");
  o.list->add_flag("--all", o.all, "with jobs that are done or withdrawn; the newest 1,000");
  o.release = command("release",
                      "offer a job again that has begun nowhere: held, failed, or at a machine that is gone");
  o.release->add_option("JOB", o.job, "its number in the shop")->required();
  o.withdraw = command("withdraw", "take a job out that has begun nowhere");
  o.withdraw->add_option("JOB", o.job, "its number in the shop")->required();
  o.raise = command(
      "raise", "after the database was restored: go on as it is now, when every machine has told its part");
  o.raise->add_flag("--yes", o.yes, "do not ask after showing which machines have not been back");
  o.watch = command("watch", "what the shop's page shows, again and again, into a file");
  o.watch->add_option("--into", o.into)->required();
  o.watch->group("");  // the desk's
}

ShopCommand::~ShopCommand() = default;

bool ShopCommand::called() const { return options_->shop->parsed(); }

int ShopCommand::Options::tell(const Result<void>& done, const ordered_json& answer,
                               const std::string& text) const {
  if (!done) return complain(done.error());
  std::cout << (as_json ? answer.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n" : text);
  return kExitDone;
}

int ShopCommand::Options::run_list() const {
  ShopView view;
  const Result<void> done = in_shop(place, true, [&](const ShopAsk& ask) -> Result<void> {
    Result<ShopView> seen = view_shop(ask, all ? ShopPick::kAll : ShopPick::kOpen);
    if (!seen) return tl::unexpected<Error>(seen.error());
    view = std::move(*seen);
    const auto usage = view_usage(ask);
    if (!usage) return tl::unexpected<Error>(usage.error());
    add_usage(*usage, view);
    return {};
  });
  return tell(done, ordered_json::parse(view_json(view)), view_text(view));
}

int ShopCommand::Options::run_init() const {
  bool fresh = false;
  const Result<void> done = in_shop(place, false, [&](const ShopAsk& ask) -> Result<void> {
    const Result<bool> made = init_shop(ask);
    if (!made) return tl::unexpected<Error>(made.error());
    fresh = *made;
    return {};
  });
  return tell(done, {{"ok", true}, {"fresh", fresh}},
              fresh ? "the shop's queue is made\n" : "the shop's queue is brought up to date\n");
}

int ShopCommand::Options::run_take_back(bool open) const {
  std::string said;
  const Result<void> done = in_shop(place, false, [&](const ShopAsk& ask) -> Result<void> {
    Result<std::string> taken = take_back(ask, job, open);
    if (!taken) return tl::unexpected<Error>(taken.error());
    said = std::move(*taken);
    return {};
  });
  return tell(done, {{"ok", true}, {"job", job}, {"text", said}}, said + "\n");
}

int ShopCommand::Options::run_raise() const {
  std::uint64_t epoch = 0;
  const Result<void> done = in_shop(place, false, [&](const ShopAsk& ask) -> Result<void> {
    const Result<ShopView> view = view_shop(ask, ShopPick::kOpen);
    if (!view) return tl::unexpected<Error>(view.error());
    std::ostream& out = as_json ? std::cerr : std::cout;  // the object stands alone
    out << (view->halted.empty() ? "the queue is not halted" : "halted: " + view->halted)
        << "\nA job that the database has forgotten, and a machine that has not been back took, is offered "
           "again.\n";
    for (const ShopMachine& one : view->machines)
      if (!one.back) out << machine_line(one);
    std::string word = "yes";
    if (!yes) {
      out << "Has every machine that took jobs been back? Type yes to go on: " << std::flush;
      std::getline(std::cin, word);
    }
    if (word != "yes") return fail(Code::kCancelled, "nothing is changed");
    const Result<std::uint64_t> raised = raise_epoch(ask);
    if (!raised) return tl::unexpected<Error>(raised.error());
    epoch = *raised;
    return {};
  });
  return tell(done, {{"ok", true}, {"epoch", epoch}}, "epoch " + std::to_string(epoch) + "\n");
}

int ShopCommand::run() const {
  const Options& o = *options_;
  if (o.init->parsed()) return o.run_init();
  if (o.watch->parsed()) {
    const Result<std::string> url = o.place.find();
    const Result<void> watched = url ? watch_shop(*url, o.into) : tl::unexpected<Error>(url.error());
    return watched ? kExitDone : complain(watched.error());
  }
  if (o.release->parsed()) return o.run_take_back(true);
  if (o.withdraw->parsed()) return o.run_take_back(false);
  if (o.raise->parsed()) return o.run_raise();
  return o.run_list();
}

}  // namespace tiltfeed::daemon
