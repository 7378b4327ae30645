#pragma once
// A conversation with a controller of the Grbl family that no run is on: one line at a time, each with its
// answer, and status reports. The one report loop of everything but a run.

#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/protocol/grbl_reply.h"
#include "daemon/wire/axis_values.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// How a controller ends its answer to a line.
enum class GrblEnd : std::uint8_t { kOk, kError, kAlarm, kRestarted };

struct GrblAnswer {
  GrblEnd end = GrblEnd::kOk;
  int code = 0;                   ///< of error:N and ALARM:N; 0: not told
  std::vector<std::string> said;  ///< what came before the end, a line each, printable
};

/// Properties: an answer belongs to the line that was asked, whatever somebody else left in the controller;
/// nothing is ever sent twice but `?` and real-time bytes.
class GrblTalk {
 public:
  /// `stopped`: the operator wants no more; what waits then ends with kCancelled.
  GrblTalk(Link& wire, Clock& clock, std::function<bool()> stopped = {});

  /// The next status report. Errors: kLink: none came within 10 s; kCancelled.
  Result<GrblStatus> report();
  /// Reports until `wanted` says yes. Errors: kLink: `seconds` are over; kCancelled.
  Result<GrblStatus> report_until(const std::function<bool(const GrblStatus&)>& wanted, double seconds);
  /// A report after the work offset has been told: it comes with every tenth or thirtieth only. Where it does
  /// not come at all, the newest report.
  Result<GrblStatus> report_with_offset();

  /// Sends a line and waits for its answer. `patience`: seconds without it in which the machine does not
  /// move. Errors: kLink; kCancelled, with the line still in work.
  Result<GrblAnswer> ask(const std::string& line, double patience = 5.0);
  /// Real-time bytes, at once.
  Result<void> urge(std::string_view bytes);
  /// A rest in which what comes is kept.
  Result<void> pause(double seconds);

  const std::vector<double>& offset() const { return offset_; }  ///< WCO; empty: not told yet
  const std::string& letters() const { return letters_; }        ///< of `$I`; empty: not told
  int alarm() const { return alarm_; }  ///< the newest ALARM:N or Alarm:N; 0: none was heard

 private:
  Result<void> settle();
  Result<GrblAnswer> answer(const std::string& line, double patience, bool identity);
  Result<void> turn(Time wait);
  Result<std::optional<GrblStatus>> take_status();
  void take_note(const GrblStatus& status);
  bool stopped() const { return stopped_ && stopped_(); }

  Link& wire_;
  Clock& clock_;
  std::function<bool()> stopped_;
  std::string out_, line_, letters_;
  std::deque<std::string> lines_;
  std::vector<double> offset_;
  int alarm_ = 0;
  bool settled_ = false;  // the next answer belongs to the next line
};

/// The axes of a report by their letters. Where `letters` are not as many as the axes: X Y Z and the
/// machine's rotaries, in the order A B C. None where that does not fit either.
AxisValues report_axes(const std::vector<double>& values, const std::string& letters,
                       const MachineModel& machine);

}  // namespace tiltfeed::daemon
