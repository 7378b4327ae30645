#include "daemon/command/send_tool.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <istream>
#include <ostream>

#include "daemon/journal/tool_return.h"
#include "daemon/machine/advice.h"
#include "daemon/machine/tool_guide.h"

namespace tiltfeed::daemon {

namespace {

/// A program of a few lines, as a file that nobody has to take away.
class ShortProgram {
 public:
  explicit ShortProgram(const std::string& text) : fd_(::memfd_create("way-back", MFD_CLOEXEC)) {
    whole_ = fd_ >= 0 && ::write(fd_, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  }
  ShortProgram(const ShortProgram&) = delete;
  ShortProgram& operator=(const ShortProgram&) = delete;
  ~ShortProgram() {
    if (fd_ >= 0) ::close(fd_);
  }
  bool whole() const { return whole_; }
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
  bool whole_ = false;
};

}  // namespace

Result<void> change_in_program(const std::string& program, const ToolChange& change,
                               const config::MachineProfile& machine, const LinkSpec& spec, Link& wire,
                               Clock& clock, const std::function<bool()>& ended, std::istream& in,
                               std::ostream& out) {
  const auto stands = [&](const Error& why) {
    return fail(why.code, why.message + "; the run ends before the tool change of line " +
                              std::to_string(change.line) + ": blocks 1 to " +
                              std::to_string(change.block - 1) + " are executed, later ones have not left");
  };
  MachineBench bench{machine, spec, wire, clock};
  bench.stopped = ended;
  StreamHooks hooks;
  SendState newest;
  hooks.progress = [&](const SendState& state) {
    newest = state;
    return !ended();
  };
  ToolGuide guide;
  guide.orders = orders_in_change(spec.kind);
  guide.act = [&](const std::string& name, const std::vector<std::string>& words) {
    return perform_order(bench, name, words);
  };
  guide.title = "tool change: " + tool_text(change) + ", before line " + std::to_string(change.line);
  ReturnOptions options;
  options.change = change.block;
  const auto park = [&]() -> Result<SendReport> {
    const Result<ToolWay> way = plan_park(program, spec.kind, machine, options);
    if (!way) return tl::unexpected<Error>(way.error());
    const ShortProgram file(way->program);
    if (!file.whole()) return fail(Code::kIo, std::string("no memory file: ") + std::strerror(errno));
    return send_over(file.path(), spec, wire, clock, {}, hooks);
  };
  const Result<SendReport> parked = park();
  // In the middle of a way the machine is no place to change a tool at.
  const auto cut = [&](const Error& error, const char* what) {
    const std::string advice = newest.sent > 0 ? "; " + cut_way_advice(spec.kind, machine.format) : "";
    return Error{error.code, what + without_range(error, newest).message + advice};
  };
  if (!parked && ended()) return stands(cut(parked.error(), "not parked: "));
  guide.title +=
      "\n" + (parked ? "parked, spindle and coolant off" : cut(parked.error(), "not parked: ").message);
  guide.wants_length = change.length.has_value();
  guide.take_length = [&](double length) {
    return judge_length(change, length, spec.profile.tool_length_tolerance);
  };
  ToolWay way;
  guide.way_back = [&]() -> Result<std::string> {
    Result<ToolWay> planned = plan_return(program, spec.kind, machine, options);
    if (!planned) return tl::unexpected<Error>(planned.error());
    way = std::move(*planned);
    return way.preview;
  };
  for (;;) {
    if (const Result<void> guided = guide_tool_change(guide, in, out); !guided) return stands(guided.error());
    const ShortProgram file(way.program);
    if (!file.whole()) return stands({Code::kIo, std::string("no memory file: ") + std::strerror(errno)});
    newest = {};
    const Result<SendReport> back = send_over(file.path(), spec, wire, clock, {}, hooks);
    if (back) return {};
    const Error error = cut(back.error(), "not back at the part: ");
    if (ended()) return stands(error);
    guide.title = error.message;
  }
}

}  // namespace tiltfeed::daemon
