#include "pathgen/envelope/smoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

/// Share of the tolerance by which the disc's places, being apart, may lift the pass square to it; less is
/// none.
constexpr double kStepShare = 0.1;
/// Places nearer to each other than this across the axis (mm) are a wall.
constexpr double kLeastStep = 1e-6;
/// Steps between two centres of the disc.
constexpr double kLongestRoll = 1.5;

/// A place of the pass seen from the side: developed length and height along the axis, mm.
struct ProfilePoint {
  double run = 0.0, height = 0.0;
};

/// The pass laid out flat, move by move.
std::vector<ProfilePoint> side_view(const Pass& pass) {
  std::vector<ProfilePoint> places(pass.size());
  for (std::size_t i = 1; i < pass.size(); ++i) {
    const Vec3 move = pass[i].centre - pass[i - 1].centre;
    const Vec3 axis = normalized(pass[i - 1].axis + pass[i].axis);
    const double rise = dot(move, axis);
    places[i] = {places[i - 1].run + length(move - axis * rise), places[i - 1].height + rise};
  }
  return places;
}

/// A disc dropped on a side view and lifted off again.
class Disc {
 public:
  Disc(std::vector<ProfilePoint> places, const Smoothing& smoothing)
      : places_(std::move(places)),
        radius_(smoothing.radius),
        least_(smoothing.tolerance * kStepShare),
        step_(std::sqrt(4.0 * smoothing.radius * least_)) {
    // Beyond the ends it hangs over them.
    const double first = places_.front().run - radius_, last = places_.back().run + radius_;
    centres_.push_back({first, rest(first)});
    const double steps = std::ceil((last - first) / step_);
    for (double k = 1.0; k <= steps; ++k) {
      const double run = std::lerp(first, last, k / steps);
      roll_to({run, rest(run)});
    }
  }

  /// The lowest that its lower side comes at `run`.
  double lower_side(double run) const {
    double lowest = std::numeric_limits<double>::infinity();
    const double reach = radius_ + kLeastStep;
    auto at = std::lower_bound(centres_.begin(), centres_.end(), run - reach,
                               [](const ProfilePoint& c, double from) { return c.run < from; });
    for (; at != centres_.end() && at->run <= run + reach; ++at)
      lowest = std::min(lowest, at->height - sagging(at->run - run));
    return lowest;
  }

  double step() const { return step_; }

 private:
  double sagging(double off) const { return std::sqrt(std::max(radius_ * radius_ - off * off, 0.0)); }

  /// Adds the centre, and others before it as long as the way there is long or bent; at a wall it rises on
  /// the spot.
  void roll_to(ProfilePoint centre) {
    const ProfilePoint last = centres_.back();
    const double gap = centre.run - last.run, rise = centre.height - last.height, far = std::hypot(gap, rise);
    if (gap > kLeastStep) {
      ProfilePoint middle{last.run + gap / 2.0, 0.0};
      middle.height = rest(middle.run);
      const double bend = std::abs(middle.height - last.height - rise / 2.0) * gap / far;
      if (far > kLongestRoll * step_ || bend > least_) {
        roll_to(middle);
        roll_to(centre);
        return;
      }
    }
    centres_.push_back(centre);
  }

  /// Height of the centre when the disc at `run` rests on the pass.
  double rest(double run) const {
    double centre = -std::numeric_limits<double>::infinity();
    auto at = std::lower_bound(places_.begin(), places_.end(), run - radius_,
                               [](const ProfilePoint& p, double from) { return p.run < from; });
    if (at != places_.begin()) --at;
    for (; at != places_.end() && at->run <= run + radius_; ++at) {
      if (at->run >= run - radius_) centre = std::max(centre, at->height + sagging(at->run - run));
      if (at + 1 != places_.end()) centre = std::max(centre, rest_on_move(*at, at[1], run));
    }
    return centre;
  }

  /// The same on one move alone; no bound where the disc touches one of its ends.
  double rest_on_move(const ProfilePoint& a, const ProfilePoint& b, double run) const {
    const double wide = b.run - a.run, high = b.height - a.height, far = std::hypot(wide, high);
    if (wide < kLeastStep) return -std::numeric_limits<double>::infinity();
    const double contact = run + radius_ * high / far;
    if (contact < a.run || contact > b.run) return -std::numeric_limits<double>::infinity();
    return a.height + high * (run - a.run) / wide + radius_ * far / wide;
  }

  std::vector<ProfilePoint> places_;
  double radius_, least_, step_;
  std::vector<ProfilePoint> centres_;  ///< in rising run, about a step apart
};

/// Cosine of the slope from a to b.
double levelness(const ProfilePoint& a, const ProfilePoint& b) {
  const double wide = b.run - a.run, far = std::hypot(wide, b.height - a.height);
  return far > 0.0 ? wide / far : 1.0;
}

EnvelopePoint raised(EnvelopePoint p, double rise) {
  p.centre = p.centre + p.axis * rise;
  p.flat.z += rise;
  return p;
}

}  // namespace

void Smoothed::add(const Smoothed& other) {
  points += other.points;
  most = std::max(most, other.most);
}

/// (E6)
Pass smoothed(const Pass& pass, const Smoothing& smoothing, Envelope& envelope, Smoothed& report) {
  if (pass.size() < 3) return pass;
  const std::vector<ProfilePoint> places = side_view(pass);
  const Disc disc(places, smoothing);
  Pass out;
  const auto add = [&](const EnvelopePoint& p, double rise, double level) {
    if (rise <= 0.0) return out.push_back(p);
    out.push_back(raised(p, rise));
    if (rise * level <= smoothing.tolerance) return;  // on a wall it slides up, and leaves nothing
    report.most = std::max(report.most, rise);
    ++report.points;
  };
  for (std::size_t i = 0; i < pass.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i, pass.size() - 2);
    add(pass[i], disc.lower_side(places[i].run) - places[i].height,
        std::max(levelness(places[before], places[before + 1]), levelness(places[after], places[after + 1])));
    if (i + 1 == pass.size()) break;
    const ProfilePoint &a = places[i], &b = places[i + 1];
    const double moves = std::ceil((b.run - a.run) / disc.step());
    for (double k = 1.0; k < moves; ++k) {
      const double share = k / moves, height = std::lerp(a.height, b.height, share);
      const double rise = disc.lower_side(std::lerp(a.run, b.run, share)) - height;
      if (rise <= smoothing.tolerance * kStepShare) continue;
      const Point<Flat> on_move = lerp(pass[i].flat, pass[i + 1].flat, share);
      if (const auto p = envelope.at(on_move.x, on_move.y)) {
        // The move runs straight where the envelope may not.
        const double above = dot(lerp(pass[i].centre, pass[i + 1].centre, share) - p->centre, p->axis);
        add(*p, rise + above, levelness(a, b));
      }
    }
  }
  return out;
}

}  // namespace tiltfeed::pathgen
