#pragma once
// The upper envelope of one slice: the highest CL point on each axis line, so that neither ball nor straight
// shank cuts into the part. (E1)..(E4) in pathgen/envelope/README.md.

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/envelope/look_choice.h"
#include "pathgen/envelope/pass.h"
#include "pathgen/surface/cl_surface.h"
#include "pathgen/surface/flat_index.h"
#include "pathgen/surface/row_candidates.h"

namespace tiltfeed::pathgen {

struct LineEnvelope {
  std::vector<Pass> passes;
  std::vector<PatchId> too_near;               ///< patches left out for kLeastAxisDistance, each once
  bool guarded = false;                        ///< shank or holder may have raised it
  std::vector<std::pair<double, double>> cut;  ///< if so: run coordinates over which the cutting part touches
};

/// The upper envelope of the CL surface over the flat space. One object a thread; surface, deformation and
/// index are shared and must outlive it.
/// Properties: 1 The place that at() gives, and each point of a line, is the highest of all patches there, to
/// the last bit. 2 Straight moves of the CL reference between two points of a line stay within
/// options.tolerance of the envelope. 3 Where at() gives a place, rises_over() tells whether that is higher.
/// 4 along() with a height gives the whole envelope where that is over the height, and nothing above it
/// elsewhere. 5 Normals are square to the CL surface as it lies in part space, whatever the axis does.
class Envelope {
 public:
  Envelope(const ClSurface& surface, const Deformation& deformation, const FlatIndex& index,
           const EnvelopeOptions& options)
      : surface_(surface), map_(deformation), index_(index), options_(options) {}

  /// Points on the envelope along the line. Steep flanks are points whose axis lines lie at most
  /// tolerance / 10 apart. A gap in the surface ends a pass.
  LineEnvelope along(const FlatLine& line);
  /// The same along line `row` of those that `rows` were made for.
  LineEnvelope along(const FlatLine& line, const RowCandidates& rows, std::size_t row);

  /// The same, but shank and holder are asked for only where they may be higher than `z`.
  LineEnvelope along(const FlatLine& line, double z);

  /// The same for a short line whose envelope is mostly about as high as at its ends. Costs less where hulls
  /// are wide.
  LineEnvelope along_short(const FlatLine& line, double z);

  /// Is the line short, and are there so many hulls in its middle that along_short() costs less than along()?
  /// The same for any thread, whatever it was asked before.
  bool is_crowded(const FlatLine& line) const;

  /// May the envelope be higher than z' anywhere on the line? By its bounds alone.
  bool may_rise_over(const FlatLine& line, double z);

  /// The envelope on one axis line; nothing where the line misses the CL surface or may not be used.
  std::optional<EnvelopePoint> at(double x, double y);
  /// Is it higher than `z` on one axis line? Costs less than at(), and does not see what is too near to the
  /// column's end where it is not higher.
  bool rises_over(double x, double y, double z);
  /// z' of the cutting part's envelope there, whether it may be used or not; minus infinity where there is
  /// none.
  double cutter_height(double x, double y) const;
  /// Shank, holder or fixtures may have raised the envelope.
  bool has_guards() const { return !index_.guards().empty(); }
  /// Is it the cutting part, against the part, that touches there?
  bool is_cut(const EnvelopePoint& p) const {
    const ToolPiece& piece = surface_.piece(p.patch);
    return piece.part == ToolPart::kCutter && !piece.at_fixtures;
  }
  /// Has these two look up the cutting part in `tree`, that of the index, which must outlive the envelope:
  /// for places in no order.
  void look_up_in(const HullBvh& tree) { places_ = &tree; }
  /// The patch for which the last place that was asked for may not be used.
  std::optional<PatchId> shut_by() const { return shut_by_; }

  const EnvelopeOptions& options() const { return options_; }

 private:
  friend class Profile;
  void look_along(const FlatLine& line);
  LineEnvelope along_candidates(const FlatLine& line, double least);
  LineEnvelope guarded(LineEnvelope found, const FlatLine& line, double least);
  std::optional<LineEnvelope> of_the_highest(const FlatLine& line, double z);
  LineEnvelope raised(const LineEnvelope& found, const FlatLine& line, const class PassFloor& floor);
  template <class Look>
  auto look_at(double x, double y, Look look);
  void look_near(std::array<double, 2> a, std::array<double, 2> b);
  bool asks_tree() const { return look_.by_tree(); }
  void count(std::size_t cost);
  bool find_guards(const FlatLine& line, const class PassFloor& floor);
  const ClSurface& surface_;
  const Deformation& map_;
  const FlatIndex& index_;
  EnvelopeOptions options_;
  FlatIndex::Scratch scratch_;
  std::vector<Candidate> met_;         ///< by the row, hull by hull
  std::vector<Candidate> candidates_;  ///< of the line, those now in use
  std::vector<Candidate> cutter_;      ///< of the cutting part
  std::vector<Candidate> guards_;      ///< of shank and holder, where they may rise
  std::optional<FlatBox> asked_;       ///< round the place that was asked for last, and what is there
  std::vector<FlatIndex::Nearby> nearby_;
  std::vector<Candidate> by_patch_;  ///< candidates_ by rising patch, where there are many
  const HullBvh* places_ = nullptr;

  LookChoice look_;
  std::span<const DropBvh> drops_;  ///< of the index, when it has them
  /// The highest of the last place, which mostly is at the next.
  DropBvh::Found last_{};

  std::optional<std::pair<Point<Part>, Vec3>>
      end_;                                ///< the column's end asked for last, the ring from there,
  std::optional<PatchId> end_covered_by_;  ///< and the patch that covers it
  std::optional<PatchId> shut_by_;
};

}  // namespace tiltfeed::pathgen
