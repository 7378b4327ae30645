#pragma once
// The bodies of a job's machine and set-up, and which of them may not meet: how near they may come, and how
// far a contact point can move between two places of the axes. Formula (CO3) is in sim/collision/README.md.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "config/job.h"
#include "pathgen/mesh/mesh.h"
#include "sim/collision/machine_line.h"
#include "sim/collision/solid_mesh.h"

namespace tiltfeed::sim {

/// Under TCP the slides' way between two places is straight to within this, mm; clearances are wider by it.
inline constexpr double kTcpStray = 0.01;

/// What a pair's clearance and its exemption go by.
enum class BodyKind : std::uint8_t {
  kPart,
  kFixture,
  kMachineUnderWork,
  kMachineOverWork,
  kCutter,
  kShank,
  kHolder
};

/// Bodies of one kind on one link.
struct BodyGroup {
  BodyKind kind = BodyKind::kPart;
  int link = 0;
  std::string word;  ///< "head", "fixture"
  BodyTree tree;
  double sagitta = 0.0;
  struct Body {
    std::string name;
    std::uint32_t end = 0;  ///< of its facets
    std::vector<Vec3> vertices;
    bool round = false;
    Vec3 centre, axis;
  };
  std::vector<Body> bodies;

  const Body& body_of(std::uint32_t facet) const;
};

/// (CO3) Two groups, and what moves them against each other.
struct BodyPair {
  std::size_t a = 0, b = 0;                       ///< a's link is nearer to the work
  double clearance = 0.0, rapid_clearance = 0.0;  ///< mm; what round meshes lack is in them
  std::array<bool, 3> slides{};
  std::array<double, 2> reach{};  ///< r of tilt and rotary, mm; 0: it does not move them against each other

  double asked(bool rapid) const { return rapid ? rapid_clearance : clearance; }
  /// No point of contact moves further when each axis moves by up to this, mm and degrees.
  double motion(const AxisWords& by) const;
};

class CollisionScene {
 public:
  /// Of pairs there are at most so many: a bit each.
  static constexpr std::size_t kMostPairs = 64;

  /// Errors: those of the STL files of bodies and fixtures.
  static Result<CollisionScene> make(const pathgen::CheckedMesh& part, const config::Job& job);

  const std::vector<BodyGroup>& groups() const { return groups_; }
  const std::vector<BodyPair>& pairs() const { return pairs_; }
  const MachineLine& line() const { return line_; }
  /// Group b of a pair as group a sees it.
  Placement pose(const BodyPair& pair, const AxisWords& words) const {
    return line_.relative(words, groups_[pair.a].link, groups_[pair.b].link);
  }
  bool nearer(const BodyPair& pair, const AxisWords& words, double distance, double slack = 0.0,
              std::uint32_t patience = 0) const {
    return groups_[pair.a].tree.nearer(groups_[pair.b].tree, pose(pair, words), distance, slack, patience);
  }

 private:
  CollisionScene(const config::Job& job) : line_(job.machine, job.setup) {}
  BodyGroup& group(BodyKind kind, int link, const std::string& word);
  void add(BodyGroup& group, const std::string& name, const SolidMesh& mesh);
  Result<void> add_machine(const config::MachineProfile& machine);
  Result<void> add_fixtures(const config::Job& job);
  void add_tool(const pathgen::Cutter& cutter);
  void add_part(const pathgen::CheckedMesh& part);
  void find_pairs(const config::Clearances& clearances, double stray);
  double reach(const BodyPair& pair, std::size_t joint) const;
  double reach_of(const BodyGroup& group, int from, int to, const LineJoint& about) const;

  MachineLine line_;
  std::vector<BodyGroup> groups_;
  std::vector<BodyPair> pairs_;
};

}  // namespace tiltfeed::sim
