#pragma once
// A job file for a part that has none yet, from what a proposal says.

#include <string>
#include <vector>

#include "config/yaml_edit.h"
#include "kinematics/basics/result.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::config {

struct NewJob {
  std::string name, stl, machine;  ///< files as they stand in the job
  double stl_unit_mm = 1.0;
  std::string cutter;  ///< as the map in a job: "type: ball, diameter_mm: 6, ..."
  pathgen::AxisFrame axis;
  double side_step = 0.0, tolerance = 0.01, clearance = 5.0, approach = 1.0;  ///< mm
  Vec3 part_zero, fixture_deg;                                                ///< mm; degrees
  Angle tilt_max = Angle::from_degrees(180.0);
  std::string feeds =
      "cut_mm_per_min: 1000, plunge_mm_per_min: 300";  ///< the map; empty: the tool's for its material
  std::vector<std::string> remarks;                    ///< comment lines at the top
  // Comment lines before a section.
  std::vector<std::string> part_remarks, cutter_remarks, pattern_remarks, setup_remarks,
      feeds_remarks{"Set them for cutter and material."};
};

/// A text that parse_job() reads as these values, directions to nine decimals.
std::string new_job_text(const NewJob& job);

/// The same placement of tool axis and part as changes to a job that there is. Keys that its mode refuses are
/// not taken out.
std::vector<YamlEdit> placement_edits(const NewJob& job);

/// As NewJob::cutter.
std::string cutter_text(const pathgen::Cutter& cutter);

/// A cutter as the section of a job, with or without the braces round it; or TYPE:DIAMETER, as ball:6, with
/// lengths by rule: the shank ten diameters long, the gauge line 60 mm above it.
struct NamedCutter {
  pathgen::Cutter cutter;
  std::string text;  ///< as NewJob::cutter
};
/// Errors: kInput as in a job; the file is called --cutter.
Result<NamedCutter> parse_cutter(const std::string& text);

/// The ball, as parse_cutter() takes it, that goes about forty times into a part of this length, mm.
std::string usual_cutter(double longest);

/// What of a file's name a job's name may have: [A-Za-z0-9 ._-]{1,40}.
std::string job_name_of(const std::string& stl);

}  // namespace tiltfeed::config
