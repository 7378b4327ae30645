#include "daemon/service/stream_thread.h"

#include <algorithm>
#include <fstream>

#include "daemon/machine/advice.h"
#include "daemon/stream/wire_log.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

/// Below so much of a run, how it keeps to the plan is not known yet.
constexpr double kScaleAfter = 10.0;
constexpr double kLeastScale = 0.2, kMostScale = 20.0;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The wire until the service lets go of it: only when the machine stands in hold.
class LentLink : public Link {
 public:
  LentLink(Link& link, const std::atomic<bool>& detach, std::function<bool()> held)
      : link_(link), detach_(detach), held_(std::move(held)) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (detach_ && held_())
      return fail(Code::kCancelled,
                  "the service has ended; the machine is held, the controller keeps the run");
    return link_.exchange(out, wait, in);
  }

 private:
  Link& link_;
  const std::atomic<bool>& detach_;
  std::function<bool()> held_;
};

}  // namespace

Result<void> can_override(const OperatorCommand& command, const RunView& run) {
  const auto refused = [](const std::string& why) { return fail(Code::kUsage, "override: " + why); };
  if (!can_order(run.link, "override")) return refused("not possible over this link; do it at the control");
  if (command.order != Order::kFeedOverride && run.link != LinkKind::kGrbl)
    return refused("this controller has a feed override only");
  const Phase phase = run.state.phase;
  if (is_opening(phase)) return refused("the controller has not taken the run yet");
  if (run.link == LinkKind::kRepRap && phase != Phase::kRun)
    return refused(std::string("this firmware takes it only while the program runs, not in ") +
                   phase_name(phase));
  return {};
}

double remaining_seconds(const ProgramTime& time, std::uint64_t executed, double run_from, double seconds) {
  const double done = time.at(executed), left = time.total() - done, own = done - run_from;
  if (own < kScaleAfter) return left;
  return left * std::clamp(seconds / own, kLeastScale, kMostScale);
}

StreamThread::~StreamThread() {
  if (thread_.joinable()) thread_.join();
}

void StreamThread::start(const RunOrder& order) {
  detach_ = streaming_ = false;
  {
    const std::lock_guard lock(mutex_);
    while (commands_.take()) continue;  // meant for the run before
    view_ = {};
    view_.link = order.run.link.kind;
    view_.subject = order.run.subject;
    for (const ToolChange& change : order.run.changes)
      if (change.block == order.run.subject.after) view_.change = change;
    view_.job = order.run.subject.job;
    view_.state.total = order.run.subject.total;
    time_.reset();
    operations_.clear();
    began_at_machine_time_.reset();
    began_ = heard_ = std::chrono::steady_clock::now();
  }
  thread_ = std::thread([this, order] { stream(order); });
}

bool StreamThread::command(std::uint64_t job, const OperatorCommand& command) {
  const std::lock_guard lock(mutex_);
  const bool here = view_.job != 0 && !view_.ended && (job == 0 || view_.job == job);
  if (!here) return false;
  if (command.order == Order::kHold) view_.tally.ask_hold(seconds_now());
  commands_.push(command);
  return true;
}

RunView StreamThread::view() const {
  const std::lock_guard lock(mutex_);
  RunView view = view_;
  const auto now = std::chrono::steady_clock::now();
  view.seconds = std::chrono::duration<double>(now - began_).count();
  // A control that is fed says nothing but XON and XOFF.
  if (view.link != LinkKind::kDrip) view.silent_seconds = std::chrono::duration<double>(now - heard_).count();
  if (!time_ || on_way_) return view;
  view.machine_seconds = time_->total();
  if (const OperationSpan* at = operation_at(operations_, std::max<std::uint64_t>(view.state.executed, 1)))
    view.operation = at->name;
  view.remaining_seconds =
      remaining_seconds(*time_, view.state.executed, began_at_machine_time_.value_or(0.0), view.seconds);
  return view;
}

std::optional<RunView> StreamThread::take_end() {
  if (!thread_.joinable() || !view().ended) return std::nullopt;
  thread_.join();
  return view();
}

bool StreamThread::note(const SendState& state) {
  streaming_ = true;
  alive_();
  const std::lock_guard lock(mutex_);
  view_.state = state;
  view_.opened = view_.opened || !(is_opening(state.phase) || is_final(state.phase));
  view_.tally.take(state, seconds_now());
  if (time_ && !began_at_machine_time_ && !is_opening(state.phase)) {
    began_at_machine_time_ = time_->at(state.executed);
    began_ = std::chrono::steady_clock::now();
  }
  return true;
}

/// While it lives what moves is no block of the program: nothing is known of the time that is left.
class StreamThread::OnWay {
 public:
  explicit OnWay(StreamThread& run) : run_(run) { set(true); }
  OnWay(const OnWay&) = delete;
  OnWay& operator=(const OnWay&) = delete;
  ~OnWay() { set(false); }

 private:
  void set(bool on) {
    const std::lock_guard lock(run_.mutex_);
    run_.on_way_ = on;
  }
  StreamThread& run_;
};

/// All before the change is executed and on record. Nothing of the job's program any more.
void StreamThread::park(const RunOrder& order, const ToolChange& change, Link& link, Clock& clock,
                        StreamHooks hooks) {
  const OnWay way(*this);
  SendState newest;
  hooks.progress = [&, owner = hooks.progress](SendState state) {
    newest = state;
    state.total = order.run.subject.total;
    state.sent = state.acknowledged = state.executed = change.block - 1;
    state.uncertain = {};
    if (state.held.empty()) state.held = "parks before the tool change";
    return owner(state);
  };
  Result<std::string> file = fail(Code::kUsage, "no way is known");
  if (order.park) file = order.park(change);
  const Result<SendReport> done = !file ? Result<SendReport>(tl::unexpected<Error>(file.error()))
                                        : send_over(*file, order.run.link, link, clock, {}, hooks);
  const std::lock_guard lock(mutex_);
  view_.parked =
      done ? "parked, spindle and coolant off" : "not parked: " + without_range(done.error(), newest).message;
  if (!done && newest.sent > 0) view_.parked += "; " + order.cut_way;
}

/// Nothing of the job's program: its figures stay as they are meanwhile.
Result<void> StreamThread::go_back(const RunOrder& order, Link& link, Clock& clock, StreamHooks hooks) {
  if (order.way_back.empty()) return {};
  const OnWay way(*this);
  SendState newest;
  hooks.progress = [&, owner = hooks.progress](SendState state) {
    newest = state;
    state.total = order.run.subject.total;
    state.sent = state.acknowledged = state.executed = order.run.subject.after - 1;
    state.uncertain = {};
    if (state.held.empty()) state.held = "goes back to the part after the tool change";
    return owner(state);
  };
  const Result<SendReport> report = send_over(order.way_back, order.run.link, link, clock, {}, hooks);
  if (!report)
    return fail(report.error().code,
                "on the way back to the part: " + without_range(report.error(), newest).message);
  return {};
}

void StreamThread::stream(const RunOrder& order) {
  const LinkSpec& spec = order.run.link;
  WireLog box(counts_numeric_blocks(spec.kind));  // requests and replies, not text
  const auto run = [&]() -> Result<SendReport> {
    // What cannot be walked has no machine time; it can still be sent.
    if (const auto time = ProgramTime::read(order.run.program, spec.kind, order.machine); time) {
      const std::lock_guard lock(mutex_);
      time_ = std::make_shared<const ProgramTime>(*time);
    }
    if (auto operations = read_operations(order.run.program, spec.kind, order.machine)) {
      const std::lock_guard lock(mutex_);
      operations_ = std::move(*operations);
    }
    Result<JournalDisk> disk = journal_file(order.journal);
    if (!disk) return tl::unexpected<Error>(disk.error());
    Result<Journal> journal = Journal::open(*disk);
    if (!journal) return tl::unexpected<Error>(journal.error());
    Result<std::unique_ptr<Link>> wire = open_link(spec);
    if (!wire) return tl::unexpected<Error>(wire.error());
    bool held = false;
    LentLink link(**wire, detach_, [&] { return held; });
    SteadyClock clock;
    StreamHooks hooks;
    hooks.commands = &commands_;
    hooks.progress = [&](const SendState& state) {
      // Held, or not even begun: nothing moves when the wire is let go.
      held = is_opening(state.phase) || (state.phase == Phase::kHold && state.machine.starts_with("Hold"));
      return note(state);
    };
    hooks.traffic = [&](Way way, std::string_view bytes, Time at) {
      box.take(way, bytes, at);
      if (way != Way::kIn) return;
      const std::lock_guard lock(mutex_);
      heard_ = std::chrono::steady_clock::now();
    };
    if (const Result<void> back = go_back(order, link, clock, hooks); !back)
      return tl::unexpected<Error>(back.error());
    Result<SendReport> done = run_job(order.run, order.decision, *journal, link, clock, hooks);
    if (done && done->change) park(order, *done->change, link, clock, hooks);
    return done;
  };
  Result<SendReport> report = run();
  if (!report) {
    std::ofstream out(order.wire_log);
    out << report.error().message << "\n" << box.text();
  }
  const std::lock_guard lock(mutex_);
  view_.ended = std::move(report);
}

}  // namespace tiltfeed::daemon
