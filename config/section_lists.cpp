// The getters of Section whose values are lists.

#include "config/description.h"
#include "config/key_log.h"
#include "config/section.h"

namespace tiltfeed::config {
namespace {

constexpr double kMaxDirection = 1e6;   // components; far from overflow when squared
constexpr double kMinDirection = 1e-6;  // shorter is taken for zero: the typed digits are noise by then

std::string item_name(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index + 1) + "]";
}

}  // namespace

void Section::complain_at(const char* key, std::size_t index, const std::string& message) const {
  complaint_->add(find(key)->items[index].place, item_name(path_of(key), index) + ": " + message);
}

Vec3 Section::vector(const char* key, Range range, std::optional<Vec3> fallback) const {
  note(key, {.kind = KeyKind::kVector,
             .range = range,
             .required = !fallback,
             .usual = fallback ? vector_text(*fallback) : ""});
  const YamlNode* node = want(key, !fallback);
  if (node == nullptr) return fallback.value_or(Vec3{});
  if (node->kind != YamlKind::kList || node->items.size() != 3) {
    // [0,5, 0, 2]: three numbers, one of them with a decimal comma.
    const bool commas = node->kind == YamlKind::kList && node->items.size() > 3;
    complain(key, "expected a list of three numbers [x, y, z], " + found(*node) +
                      (commas ? "; decimal commas? Write decimals with a point" : ""));
    return fallback.value_or(Vec3{});
  }
  const auto component = [&](std::size_t i) {
    return finite(node->items[i], path_of(key), key, range).value_or(0.0);
  };
  const double x = component(0), y = component(1), z = component(2);
  return {x, y, z};
}

Vec3 Section::direction(const char* key, std::optional<Vec3> fallback) const {
  note(key,
       {.kind = KeyKind::kDirection, .required = !fallback, .usual = fallback ? vector_text(*fallback) : ""});
  const Vec3 v = vector(key, {-kMaxDirection, kMaxDirection}, fallback);
  if (length(v) >= kMinDirection) return normalized(v);
  complain(key, "the zero vector has no direction; expected at least one component other than 0");
  return {0, 0, 1};
}

std::vector<std::string> Section::lines(const char* key, std::size_t most) const {
  note(key, {.kind = KeyKind::kText, .most = most});
  const YamlNode* node = find(key);
  if (node == nullptr) return {};
  if (node->kind == YamlKind::kScalar) {
    const std::string one = text(key, "");
    return one.empty() ? std::vector<std::string>{} : std::vector<std::string>{one};
  }
  if (node->kind != YamlKind::kList || node->items.empty() || node->items.size() > most) {
    complain(key, "expected a text or a list of 1 to " + std::to_string(most) + " texts, " + found(*node));
    return {};
  }
  std::vector<std::string> all;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const YamlNode& item = node->items[i];
    const bool printable = std::all_of(item.text.begin(), item.text.end(),
                                       [](unsigned char byte) { return byte >= 0x20 && byte != 0x7F; });
    if (item.kind != YamlKind::kScalar || item.text.empty() || !printable) {
      complain_at(key, i, "expected one line of text, " + found(item));
      return {};
    }
    all.push_back(item.text);
  }
  return all;
}

std::vector<Vec3> Section::directions(const char* key, std::size_t most) const {
  note(key, {.kind = KeyKind::kDirections, .required = true, .least = 1, .most = most});
  const YamlNode* node = want(key, true);
  if (node == nullptr) return {};
  if (node->kind != YamlKind::kList || node->items.empty() || node->items.size() > most) {
    complain(key,
             "expected a list of 1 to " + std::to_string(most) + " directions [x, y, z], " + found(*node));
    return {};
  }
  std::vector<Vec3> directions;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const YamlNode& item = node->items[i];
    if (item.kind != YamlKind::kList || item.items.size() != 3) {
      complain_at(key, i, "expected a list of three numbers [x, y, z], " + found(item));
      return {};
    }
    std::array<double, 3> v{};
    for (std::size_t k = 0; k < v.size(); ++k)
      v[k] = finite(item.items[k], item_name(path_of(key), i), key, {-kMaxDirection, kMaxDirection})
                 .value_or(1.0);
    if (length({v[0], v[1], v[2]}) < kMinDirection) {
      complain_at(key, i, "the zero vector has no direction; expected at least one component other than 0");
      return {};
    }
    directions.push_back(normalized({v[0], v[1], v[2]}));
  }
  return directions;
}

std::optional<std::array<double, 2>> Section::pair(const YamlNode& node, const std::string& name,
                                                   const char* key, Range first, Range second) const {
  if (node.kind != YamlKind::kList || node.items.size() != 2) {
    complaint_->add(node.place, name + ": expected a list of two numbers, " + found(node));
    return std::nullopt;
  }
  const auto u = finite(node.items[0], name, key, first), v = finite(node.items[1], name, key, second);
  if (!u || !v) return std::nullopt;
  return std::array<double, 2>{*u, *v};
}

std::optional<std::array<double, 2>> Section::interval(const char* key, Range range) const {
  note(key, {.kind = KeyKind::kInterval, .range = range});
  const YamlNode* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto ends = pair(*node, path_of(key), key, range, range);
  if (!ends) return std::nullopt;
  if ((*ends)[0] < (*ends)[1]) return ends;
  complain(key, "the interval from " + exact_text((*ends)[0]) + " to " + exact_text((*ends)[1]) +
                    " is empty; expected [low, high] with low below high");
  return std::nullopt;
}

std::vector<std::array<double, 2>> Section::points(const char* key, Range u, Range v, std::size_t least,
                                                   std::size_t most) const {
  note(key, {.kind = KeyKind::kPoints, .least = least, .most = most});
  const YamlNode* node = find(key);
  if (node == nullptr) return {};
  if (node->kind != YamlKind::kList || node->items.size() < least || node->items.size() > most) {
    complain(key, "expected a list of " + std::to_string(least) + " to " + std::to_string(most) +
                      " corners [u, v], " + found(*node));
    return {};
  }
  std::vector<std::array<double, 2>> points;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const auto point = pair(node->items[i], item_name(path_of(key), i), key, u, v);
    if (!point) return {};
    points.push_back(*point);
  }
  return points;
}

std::vector<Section> Section::list(const char* key, std::initializer_list<const char*> known,
                                   std::size_t most) const {
  note(key, {.kind = KeyKind::kList, .words = {known.begin(), known.end()}, .least = 1, .most = most});
  const YamlNode* node = find(key);
  if (node == nullptr) return {};
  if (node->kind != YamlKind::kList || node->items.empty() || node->items.size() > most) {
    complain(key, "expected a list of 1 to " + std::to_string(most) + " maps, " + found(*node));
    return {};
  }
  std::vector<Section> sections;
  for (std::size_t i = 0; i < node->items.size(); ++i)
    sections.push_back(Section(node->items[i], item_name(path_of(key), i), known, *complaint_));
  return sections;
}

}  // namespace tiltfeed::config
