#include "daemon/command/submit_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "daemon/command/command.h"
#include "daemon/command/service_talk.h"
#include "daemon/command/shop_needs.h"
#include "daemon/command/shop_session.h"
#include "daemon/command/submission.h"
#include "daemon/service/api.h"
#include "daemon/service/spool.h"
#include "daemon/shop/shop_orders.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

}  // namespace

struct SubmitCommand::Options {
  CLI::App* submit = nullptr;
  std::string socket, file, name, id;
  ShopPlace place;
  ShopWishes wishes;
  bool as_json = false;

  bool to_shop() const { return !place.url.empty() || !place.config.empty(); }
  int tell(const ordered_json& answer, const std::string& text) const;
  int run_service() const;
  int run_shop() const;
};

SubmitCommand::SubmitCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.socket = service_socket();
  o.submit =
      app.add_subcommand("submit", "hand a job (YAML) or a program (G-code) to the service, or to the shop");
  CLI::Option* const socket = o.submit->add_option(
      "--socket", o.socket,
      "the service's socket (default: $TILTFEED_SOCKET, else " + std::string(kDefaultSocket) + ")");
  o.submit->add_flag("--json", o.as_json, "print one JSON object");
  o.submit->add_option("FILE", o.file, "job file, or program (.nc, .ngc, .gcode, .tap)")->required();
  o.submit->add_option("--name", o.name, "for people; default: the file's");
  o.submit
      ->add_option(
          "--shop", o.place.url,
          "to the shop's queue, postgresql://USER@HOST/DATABASE?passfile=FILE, for whichever machine fits")
      ->excludes(socket);
  o.submit->add_option("--config", o.place.config, "likewise: to the queue in a service's file (YAML)")
      ->excludes(socket)
      ->excludes("--shop");
  o.submit->add_option("--machine", o.wishes.machine,
                       "of a program for the shop: the machine profile (YAML) that it was made for");
  o.submit->add_flag(
      "--any-values", o.wishes.any_values,
      "of a program for the shop: a profile of the same name is enough, whatever its travels, pivots, signs");
  o.submit->add_flag("--any-machine", o.wishes.any_machine,
                     "of a job for the shop: it is planned for whichever machine takes it, not only those of "
                     "its profile's name");
  o.submit->add_option("--tool", o.wishes.tools,
                       "for the shop: a tool that it needs besides those that are found, by id or number");
  o.submit->add_option("--id", o.id, "for the shop: the job's UUID; the same one again makes no second job");
}

SubmitCommand::~SubmitCommand() = default;

bool SubmitCommand::called() const { return options_->submit->parsed(); }

int SubmitCommand::Options::tell(const ordered_json& answer, const std::string& text) const {
  std::cout << (as_json ? answer.dump(-1, ' ', true, ordered_json::error_handler_t::replace) : text) << "\n";
  return kExitDone;
}

int SubmitCommand::Options::run_service() const {
  const bool wishes_any =
      !wishes.machine.empty() || wishes.any_values || wishes.any_machine || !wishes.tools.empty();
  if (wishes_any || !id.empty())
    return complain(
        {Code::kUsage,
         "--machine, --any-values, --any-machine, --tool and --id are for the shop's queue: add --shop or "
         "--config"});
  const Result<Submission> submission = Submission::open(file);
  if (!submission) return complain(submission.error());
  ApiRequest request;
  request.op = ApiOp::kSubmit;
  request.program = submission->program;
  request.name = name.empty() ? submission->name : name;
  const Result<std::string> answer = ask_json(socket, request, submission->files);
  if (!answer) return complain(answer.error());
  const ordered_json job = ordered_json::parse(*answer);
  return tell(job, std::to_string(job.value("job", std::uint64_t{0})));
}

int SubmitCommand::Options::run_shop() const {
  const Result<Submission> submission = Submission::open(file);
  if (!submission) return complain(submission.error());
  const Result<FoundNeeds> found = find_needs(file, submission->program, wishes);
  if (!found) return complain(found.error());
  ShopSubmission job{id.empty() ? make_uuid() : id, plain_name(name.empty() ? submission->name : name),
                     submission->program, found->needs, submission->files};
  std::uint64_t number = 0;
  ShopEntry fit;
  const Result<void> done = in_shop(place, true, [&](const ShopAsk& ask) -> Result<void> {
    const Result<std::uint64_t> given = submit_to_shop(ask, job);
    if (!given) return tl::unexpected<Error>(given.error());
    number = *given;
    const Result<ShopView> view = view_shop(ask, ShopPick::kOpen);
    if (!view) return tl::unexpected<Error>(view.error());
    judge_fit(job.needs, view->machines, fit);
    return {};
  });
  if (!done) {
    const std::string again = done.error().code == Code::kLink ? "; submit it again with --id " + job.id : "";
    return complain({done.error().code, file + ": " + done.error().message + again});
  }
  if (!found->unread.empty()) std::cerr << "tiltfeed: " << found->unread << "\n";
  if (!fit.fits_one) std::cerr << "tiltfeed: no machine that is known fits: " << fit.why_not << "\n";
  return tell({{"ok", true},
               {"job", number},
               {"id", job.id},
               {"needs", ordered_json::parse(needs_json(job.needs))},
               {"fits_one", fit.fits_one},
               {"why_not", fit.why_not}},
              std::to_string(number));
}

int SubmitCommand::run() const {
  return options_->to_shop() ? options_->run_shop() : options_->run_service();
}

}  // namespace tiltfeed::daemon
