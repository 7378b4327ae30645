// A tool change in the middle of a program: the run has ended before it, the operator makes it, the machine
// goes back, the run goes on.

#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/job.h"
#include "config/output_file.h"
#include "daemon/journal/tool_return.h"
#include "daemon/machine/advice.h"
#include "daemon/program/operation_span.h"
#include "daemon/service/entry_hold.h"
#include "daemon/service/job_service.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

using PlanWay = Result<ToolWay> (*)(const std::string&, LinkKind, const config::MachineProfile&,
                                    const ReturnOptions&);

/// The job's file and the operation in which the change is.
config::JobFiles files_of(const WayOrder& order) {
  config::JobFiles files{.stl = order.stl, .machine = order.machine.path, .closed = true};
  if (const auto operations = read_operations(order.program, order.kind, order.machine.model))
    if (const OperationSpan* at = operation_at(*operations, order.change)) files.operation = at->name;
  return files;
}

Result<ToolWay> plan_way(const WayOrder& order, PlanWay plan) {
  ReturnOptions options;
  options.change = order.change;
  if (const auto planned = config::load_job_with(order.yaml, files_of(order)); planned) {
    options.plunge_feed = planned->plan.plunge_feed.mm_per_min();
    options.setup = planned->setup;
  }
  return plan(order.program, order.kind, order.machine, options);
}

/// The way back with what is known of it. Errors: those of hold_way_back, too.
Result<ToolWay> plan_way_back(const WayOrder& order, const LinkSpec& link) {
  Result<ToolWay> way = plan_way(order, plan_return);
  if (!way) return way;
  EntrySetup setup;
  std::error_code none;
  if (std::filesystem::exists(order.yaml, none))
    setup = {order.yaml, order.stl, order.machine.path, files_of(order).operation};
  // Whatever is wrong with the wire is the run's to say.
  const auto stands = where_it_stands(link, order.machine.model);
  if (!stands || !*stands) {
    way->preview +=
        "not held against part, fixtures and machine: " +
        (stands ? std::string("the machine does not report where it stands") : stands.error().message) + "\n";
    return way;
  }
  const Result<std::string> held = hold_way_back(way->program, order.machine, **stands, setup, link.kind);
  if (!held) return tl::unexpected<Error>(held.error());
  way->preview += *held;
  return way;
}

Result<std::string> write_way(const Result<ToolWay>& way, const std::string& file) {
  if (!way) return tl::unexpected<Error>(way.error());
  if (const auto written = config::write_file(file, way->program); !written)
    return tl::unexpected<Error>(written.error());
  return file;
}

}  // namespace

/// From the end of a run, of its way back, or of an earlier service. `why`: what went wrong; empty: nothing.
void JobService::stand_before(SpooledJob job, const ToolChange& change, const std::string& parked,
                              const std::string& why) {
  job.executed = change.block - 1;
  set(job, JobState::kToolChange,
      tool_text(change) + ", before line " + std::to_string(change.line) + (why.empty() ? "" : "; " + why));
  changing_ = {job.id, change, parked, {}};
  log(Severity::kInfo, job.id, "tool change: " + parked);
}

/// What StreamThread calls, on its own thread.
std::function<Result<std::string>(const ToolChange&)> JobService::parking(std::uint64_t job) const {
  return [order = way_order(job), file = spool_.file(job, "park.nc")](const ToolChange& change) {
    WayOrder way = order;
    way.change = change.block;
    return write_way(plan_way(way, plan_park), file);
  };
}

WayOrder JobService::way_order(std::uint64_t job) const {
  return {spool_.file(job, "program.nc"),
          spool_.file(job, "job.yaml"),
          spool_.file(job, "part.stl"),
          link_.kind,
          config_.machine,
          0};
}

std::string JobService::change_text() const {
  const Changing& now = changing_;
  std::string text = "tool change: " + tool_text(now.change) + ", before line " +
                     std::to_string(now.change.line) + "\nmachine: " + now.parked;
  if (now.change.length) text += "\nthe program is for a tool of " + decimal(*now.change.length, 4) + " mm";
  text += "\nmounted: " + (now.length ? decimal(*now.length, 4) + " mm" : "its length is not known yet");
  return text;
}

/// Held against the length that the program says is in its words.
Result<std::string> JobService::take_length(const SpooledJob& job, const std::string& text) {
  double length = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), length);
  const bool number = read.ec == std::errc() && read.ptr == text.data() + text.size();
  const auto judged =
      judge_length(changing_.change, number ? length : 0.0, link_.profile.tool_length_tolerance);
  if (!judged) return tl::unexpected<Error>(judged.error());
  changing_.length = length;
  log(Severity::kInfo, job.id, "tool change: " + *judged);
  return write_text(*judged);
}

void JobService::tool(const SpooledJob& job, const ApiRequest& request, Done done) {
  if (job.state != JobState::kToolChange || changing_.job != job.id) {
    const std::string advice = tool_by_hand_advice(link_.kind);
    return done(fail(Code::kUsage, name_of(job.id) + " is " + shown_state(job) +
                                       ": it waits for no tool change" +
                                       (advice.empty() ? "" : "; " + advice)));
  }
  if (request.command == "go") return go_back(job, request.confirmed, std::move(done));
  if (request.command == "length") return done(take_length(job, request.words));
  const std::string orders = orders_in_change(link_.kind);
  if (!request.command.empty())
    return done(fail(Code::kUsage, "tool: nothing, length and go are possible" +
                                       (orders.empty() ? "" : "; of the machine's own commands " + orders)));
  ordered_json shown = ordered_json::parse(job_json(job, queue()));
  shown.update({{"v", kApiVersion}, {"ok", true}, {"text", change_text()}, {"orders", orders}});
  done(shown.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n");
}

/// First the operator sees what would move; said again with the confirmation it moves, and the run goes on.
void JobService::go_back(const SpooledJob& job, bool confirmed, Done done) {
  if (const Result<void> free = machine_free(job.id); !free) return done(tl::unexpected<Error>(free.error()));
  if (changing_.job != job.id)
    return done(fail(Code::kUsage, name_of(job.id) + ": what it waits for is not known; stop it"));
  if (changing_.change.length && !changing_.length)
    return done(fail(Code::kUsage, "say first how long the tool is (`tiltfeed tool " +
                                       std::to_string(job.id) + " length MM`): the program is for " +
                                       decimal(*changing_.change.length, 4) + " mm"));
  WayOrder order = way_order(job.id);
  order.change = changing_.change.block;
  if (!confirmed) {
    const auto look = [order, link = link_]() -> Errands::Then {
      return [way = plan_way_back(order, link)]() -> Result<std::string> {
        if (!way) return tl::unexpected<Error>(way.error());
        return write_text(way->preview, "confirm");
      };
    };
    return errands_.begin({job.id, false, true}, look, std::move(done));
  }
  const auto write = [this, order, job, link = link_,
                      file = spool_.file(job.id, "way-back.nc")]() -> Errands::Then {
    const auto prepare = [&]() -> Result<ProgramRun> {
      if (const auto way = write_way(plan_way_back(order, link), file); !way)
        return tl::unexpected<Error>(way.error());
      Result<ProgramRun> run = prepare_spooled(job, order.program, link);
      if (run) run->stand_at(order.change);
      return run;
    };
    return [this, job, file, prepared = prepare()]() -> Result<std::string> {
      if (!prepared) return tl::unexpected<Error>(prepared.error());
      ResumeDecision made;
      made.way = ResumeWay::kToolChange;
      made.executed = prepared->subject.after - 1;
      return run(job, *prepared, made, file);
    };
  };
  errands_.begin({job.id, true, true}, write, std::move(done));
}

}  // namespace tiltfeed::daemon
