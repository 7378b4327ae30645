#pragma once
// The reader of CL text: what is in force, record by record. apt_file.cpp moves the tool, apt_settings.cpp
// does the rest.

#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/cl_text/apt_arc.h"
#include "kinematics/cl_text/apt_cycle.h"
#include "kinematics/cl_text/apt_frame.h"
#include "kinematics/cl_text/apt_notes.h"
#include "kinematics/cl_text/apt_operation.h"
#include "kinematics/cl_text/apt_record.h"

namespace tiltfeed {

class AptReader {
 public:
  AptReader(std::string name, const AptOptions& options);

  /// The unit of the records before the first motion, of which it is asked first.
  Result<void> take_unit(const std::vector<AptRecord>& head);
  Result<void> read(const AptRecord& record);
  bool ended() const { return ended_; }
  Result<AptProgram> finish(std::uint32_t line);

 private:
  // apt_file.cpp
  AptVerdict dispatch(const AptRecord& record);
  bool flows(const AptRecord& record);
  AptVerdict leave_out(const AptRecord& record);
  AptVerdict go(const AptRecord& record);
  AptVerdict place_of(const AptRecord& record, Point<Part>& tip);
  AptVerdict go_by(const AptRecord& record);
  AptVerdict reach(Point<Part> tip, std::uint32_t line);
  AptVerdict along_arc(Point<Part> tip, std::uint32_t line);
  AptVerdict hole(Point<Part> tip, std::uint32_t line);
  AptVerdict put(Point<Part> tip, bool rapid, double feed, std::uint32_t line);
  AptVerdict feed_in_force(double& rate) const;

  // apt_settings.cpp
  bool settings(const AptRecord& record, AptVerdict& verdict);
  AptVerdict set_axis(double i, double j, double k);
  AptVerdict tool_axis(const AptRecord& record);
  AptVerdict rate(std::string_view unit, double value, double& feed, bool& per_turn) const;
  AptVerdict feed(const AptRecord& record);
  AptVerdict spindle(const AptRecord& record);
  AptVerdict coolant(const AptRecord& record);
  AptVerdict tool(const AptRecord& record);
  AptVerdict cutter(AptRecord record);
  AptVerdict units(const AptRecord& record, double& unit_mm) const;
  AptVerdict dwell(const AptRecord& record);
  AptVerdict compensation(const AptRecord& record);
  AptVerdict cycle(const AptRecord& record);
  AptVerdict circle(const AptRecord& record);
  AptVerdict frame(const AptRecord& record);
  AptVerdict mode(const AptRecord& record);

  AptOperation& operation() { return program_.operations.back(); }
  tl::unexpected<Error> wrong(AptPlace place, const std::string& what) const;
  void event(EventKind kind, double value, const std::string& text = "") {
    operation().events.push_back({operation().path.moves.size(), kind, value, text});
  }
  void note(const AptRecord& record, const std::string& what) { notes_.add(record.place.line, what); }
  Vec3 axis_P() const { return frame_.turn * axis_; }

  std::string name_;
  AptOptions options_;
  AptProgram program_;
  AptNotes notes_;
  double unit_;
  bool known_;  ///< the unit is stated
  double length_ = 0.0, feed_ = 0.0, rpm_ = 0.0, turn_ = 1.0;
  bool per_turn_ = false, rapid_ = false, ended_ = false, closed_ = false;
  bool moved_ = false, one_axis_ = false, world_ = false, compensated_ = false;
  Point<Part> at_{};          ///< where the tool is, part frame, mm
  Vec3 axis_{0.0, 0.0, 1.0};  ///< in the file's frame
  AptFrame frame_;
  ToolData cutter_{};
  std::optional<AptArc> arc_;
  AptCycle cycle_;
  bool cycling_ = false;
  bool low_ = false;        ///< the tool stands above a hole, no higher than its clearance
  bool elsewhere_ = false;  ///< FROM/ stated another place than the last point
  Point<Part> cycle_start_{};
};

}  // namespace tiltfeed
