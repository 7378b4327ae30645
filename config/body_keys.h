#pragma once
// The keys of bodies, slides and clearances in a machine profile, and of fixtures in a job.

#include <string>
#include <vector>

#include "config/description.h"
#include "config/machine_bodies.h"
#include "config/section.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed::config {

/// `path`: of the file that is read; STL files lie relative to its folder.
MachineBodies read_bodies(const Section& root, const MachineModel& model, const std::string& path);
std::vector<Fixture> read_fixtures(const Section& root, const std::string& path);
void describe_bodies(Description& out, const MachineBodies& machine);
void describe_fixtures(Description& out, const std::vector<Fixture>& fixtures);

/// Rz Ry Rx: about x first, then y, then z; exact for multiples of 90 degrees.
Rotation rotation_by_degrees(Vec3 degrees);
/// The key `unit` of an STL file: mm, inch, m or a number of mm.
double read_stl_unit(const Section& section);
/// `name` as the settings file means it: relative to that file's folder.
std::string beside_file(const std::string& path, const std::string& name);

}  // namespace tiltfeed::config
