#pragma once
// Typed, checked reading of one map of a settings file. Every value is asked for by key, with its range; the
// unit is the key's ending (side_step_mm). Problems are kept and every getter then returns some harmless
// value, so a reader asks for all it needs and looks at the problems once, at the end.

#include <array>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "config/range.h"
#include "config/yaml_tree.h"
#include "kinematics/basics/geometry.h"

namespace tiltfeed::config {

struct KeyFact;
class KeyLog;

/// The problems found in one file.
class Complaint {
 public:
  /// `log`: is told of every key that is asked for; must outlive the object.
  explicit Complaint(std::string file, KeyLog* log = nullptr) : file_(std::move(file)), log_(log) {}
  void add(TextPlace place, const std::string& message, Code code = Code::kInput);
  /// A required key that is absent, as a problem.
  void add_missing(TextPlace place, const std::string& key);
  /// Those keys, as dotted paths; from now on they are the caller's matter and no problems any more.
  std::vector<std::string> take_missing();
  /// There is a problem with the value at that place.
  bool tells_of(TextPlace place) const;
  /// A word of that section that decides which of its keys are used is missing or wrong.
  void doubt(const std::string& section) { doubtful_.insert(section); }
  bool doubts(const std::string& section) const { return doubtful_.contains(section); }
  /// Nothing without a problem; else the first, and a line for each other one, with the code of the first.
  std::optional<Error> error() const;
  KeyLog* log() const { return log_; }

 private:
  std::string file_;
  KeyLog* log_;
  struct Problem {
    TextPlace place;
    std::string message;
    std::string missing = {};  ///< the key; empty: another problem
  };
  std::vector<Problem> problems_;
  std::set<std::string> doubtful_;
  Code code_ = Code::kInput;  ///< of the first
};

/// One word that a key may have, and what it means.
template <class E>
struct EnumWord {
  const char* word;
  E value;
};

/// The getters take a fallback; without one the key is required.
class Section {
 public:
  /// Complains about unknown keys (with the nearest known one) and about a node that is not a map.
  /// `name`: dotted path for messages, empty for the root. Requires: node and complaint outlive it.
  Section(const YamlNode& node, std::string name, std::initializer_list<const char*> known,
          Complaint& complaint);

  Section section(const char* key, std::initializer_list<const char*> known) const;
  /// Absent: a section in which every key is absent.
  Section optional_section(const char* key, std::initializer_list<const char*> known) const;

  double number(const char* key, Range range, std::optional<double> fallback = {}) const;
  /// Nothing where absent.
  std::optional<double> optional_number(const char* key, Range range) const;
  int integer(const char* key, int min, int max, std::optional<int> fallback = {}) const;
  bool flag(const char* key, bool fallback) const;
  /// [low, high] with low < high; nothing where absent or wrong.
  std::optional<std::array<double, 2>> interval(const char* key, Range range) const;
  /// A list of `least` to `most` pairs [u, v]; empty where absent or wrong.
  std::vector<std::array<double, 2>> points(const char* key, Range u, Range v, std::size_t least,
                                            std::size_t most) const;
  /// A list of 1 to `most` maps, each a section named key[1], key[2] ...; empty where absent or wrong.
  std::vector<Section> list(const char* key, std::initializer_list<const char*> known,
                            std::size_t most) const;
  Vec3 vector(const char* key, Range range, std::optional<Vec3> fallback = {}) const;
  /// A vector of any length but zero, made unit.
  Vec3 direction(const char* key, std::optional<Vec3> fallback = {}) const;
  /// A list of 1 to `most` vectors, each made unit; required. Empty where wrong.
  std::vector<Vec3> directions(const char* key, std::size_t most) const;
  /// One line of printable text without blanks at its ends, not empty unless `fallback` is.
  std::string text(const char* key, std::optional<std::string> fallback = {}) const;
  /// A text, or a list of 1 to `most` texts, each as above; empty where absent, wrong or the text is empty.
  std::vector<std::string> lines(const char* key, std::size_t most) const;
  /// [A-Za-z0-9 ._-]{1,40}: safe in file names, G-code comments and CL text.
  std::string name(const char* key) const;
  template <class E>
  E choice(const char* key, std::initializer_list<EnumWord<E>> choices,
           std::optional<E> fallback = {}) const {
    std::vector<std::string> words;
    const char* usual = nullptr;
    for (const EnumWord<E>& choice : choices) {
      words.push_back(choice.word);
      if (fallback && *fallback == choice.value) usual = choice.word;
    }
    const std::optional<std::size_t> index = choose(key, words, fallback.has_value(), usual);
    if (index) return choices.begin()[*index].value;
    return fallback.value_or(choices.begin()->value);
  }

  bool has(const char* key) const { return find(key) != nullptr; }
  /// Present, and nothing is wrong with the value so far: another may be compared with it.
  bool sound(const char* key) const;
  /// The scalar's text as written, or nothing.
  std::optional<std::string> scalar(const char* key) const;
  /// "section.key: message" at the key's value, or at the section where the key is absent.
  void complain(const char* key, const std::string& message, Code code = Code::kInput) const;
  /// "section.key[number]: message" at that item of the list at `key`.
  void complain_at(const char* key, std::size_t index, const std::string& message) const;
  /// Complains where the key is present: "not used " + why + "; remove it". Says nothing where a word of the
  /// section is wrong: then it is not known which keys are used.
  void unused(const char* key, const std::string& why) const;

 private:
  Section(std::string name, std::initializer_list<const char*> known, Complaint& complaint);

  const YamlNode* find(const char* key) const;
  /// The value; complains when it is required and absent.
  const YamlNode* want(const char* key, bool required) const;
  std::string path_of(const char* key) const;
  /// `node` is the value of `key`, or a number in it; `name` is the key's or the item's.
  std::optional<double> finite(const YamlNode& node, const std::string& name, const char* key,
                               Range range) const;
  std::optional<std::array<double, 2>> pair(const YamlNode& node, const std::string& name, const char* key,
                                            Range first, Range second) const;
  std::optional<std::size_t> choose(const char* key, const std::vector<std::string>& words, bool optional,
                                    const char* usual) const;
  void check_keys() const;
  /// Tells the log, if there is one; path, presence and place are filled in.
  void note(const char* key, const KeyFact& fact) const;

  const YamlNode* map_ = nullptr;  ///< null: absent or not a map
  std::string name_;
  std::vector<std::string> known_;
  Complaint* complaint_;
};

}  // namespace tiltfeed::config
