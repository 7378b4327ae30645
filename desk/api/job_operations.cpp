// The list of operations in the job's text, changed where it stands.

#include <algorithm>

#include "config/job_catalogue.h"
#include "config/list_edit.h"
#include "config/text_layout.h"
#include "desk/api/job_work.h"

namespace tiltfeed::desk {
namespace {

constexpr const char* kList = "operations";
/// Keys of a job that an operation may state itself, but for those of `program`.
constexpr const char* kOwn[] = {"cutter",       "axis",         "pattern", "rest",       "containment",
                                "tolerance_mm", "allowance_mm", "stock",   "points",     "guards",
                                "links",        "clearance_mm", "feeds",   "approach_mm"};
constexpr const char* kOwnOfProgram[] = {"program.tool", "program.length_register", "program.coolant",
                                         "program.smoothing", "program.smoothing_tolerance_mm"};
constexpr std::size_t kLongestName = 40;

std::string item(std::size_t number) { return std::string(kList) + "[" + std::to_string(number) + "]"; }

/// A value in one line, as it may stand in braces.
std::string flow_text(const config::YamlNode& node) {
  std::string text;
  switch (node.kind) {
    case config::YamlKind::kNothing:
      return "";
    case config::YamlKind::kScalar:
      return node.plain && node.text.find_first_of(",[]{}#:&*!|>'\"%@`") == node.text.npos
                 ? node.text
                 : config::quoted_text(node.text);
    case config::YamlKind::kList:
      for (const config::YamlNode& one : node.items) text += (text.empty() ? "" : ", ") + flow_text(one);
      return "[" + text + "]";
    case config::YamlKind::kMap:
      for (std::size_t i = 0; i < node.keys.size(); ++i)
        text += (text.empty() ? "" : ", ") + node.keys[i].text + ": " + flow_text(node.items[i]);
      return "{" + text + "}";
  }
  return text;
}

/// What the job says for all at "pattern" or "program.tool"; null: nothing.
const config::YamlNode* shared_value(const config::YamlNode& tree, const std::string& path) {
  const std::size_t dot = path.find('.');
  const auto index = config::key_index(tree, path.substr(0, dot));
  if (!index) return nullptr;
  const config::YamlNode& node = tree.items[*index];
  if (dot == path.npos) return &node;
  const auto inner = config::key_index(node, path.substr(dot + 1));
  return inner ? &node.items[*inner] : nullptr;
}

}  // namespace

Result<void> JobWork::check_new_name(const std::string& name) const {
  const bool fits =
      !name.empty() && name.size() <= kLongestName && name.front() != ' ' && name.back() != ' ' &&
      name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789 ._-") ==
          name.npos;
  if (!fits)
    return fail(Code::kUsage, config::quoted(name) +
                                  " is no name of an operation; expected 1 to 40 of A-Z a-z 0-9 blank . _ -");
  const auto operations = config::operation_keys(text_);
  if (!operations) return tl::unexpected<Error>(operations.error());
  for (const config::OperationKeys& one : *operations)
    if (one.number > 0 && one.name == name)
      return fail(Code::kUsage, "an operation is called " + config::quoted(name) + " already");
  return {};
}

Result<void> JobWork::copy_operation(std::size_t number, const std::string& name) {
  if (!is_open()) return fail(Code::kUsage, "no job is open");
  if (const Result<void> fits = check_new_name(name); !fits) return fits;
  const auto operations = config::operation_keys(text_);
  if (!operations) return tl::unexpected<Error>(operations.error());
  if (operations->size() == 1 && operations->front().number == 0) {
    const std::string first = name == "first" ? "operation 1" : "first";
    return edit(
        {{kList, "[{name: " + config::quoted_text(first) + "}, {name: " + config::quoted_text(name) + "}]"}});
  }
  const Result<std::string> copied = config::item_copied(text_, kList, number);
  if (!copied) return tl::unexpected<Error>(copied.error());
  const Result<std::string> named =
      config::edited(*copied, {item(number + 1) + ".name", config::quoted_text(name)}, {});
  return named ? set_text(*named) : tl::unexpected<Error>(named.error());
}

Result<void> JobWork::move_operation(std::size_t from, std::size_t to) {
  if (!is_open()) return fail(Code::kUsage, "no job is open");
  const Result<std::string> moved = config::item_moved(text_, kList, from, to);
  return moved ? set_text(*moved) : tl::unexpected<Error>(moved.error());
}

Result<void> JobWork::take_out_operation(std::size_t number) {
  if (!is_open()) return fail(Code::kUsage, "no job is open");
  const Result<std::string> without = config::item_taken_out(text_, kList, number);
  return without ? set_text(*without) : tl::unexpected<Error>(without.error());
}

Result<void> JobWork::set_own(std::size_t number, const std::string& section, bool own) {
  if (!is_open()) return fail(Code::kUsage, "no job is open");
  const auto is = [&](const char* known) { return section == known; };
  if (std::none_of(std::begin(kOwn), std::end(kOwn), is) &&
      std::none_of(std::begin(kOwnOfProgram), std::end(kOwnOfProgram), is))
    return fail(Code::kUsage, config::quoted(section) + " is nothing that an operation has by itself");
  const auto operations = config::operation_keys(text_);
  if (!operations) return tl::unexpected<Error>(operations.error());
  if (number < 1 || number > operations->size() || operations->front().number == 0)
    return fail(Code::kUsage, "there is no operation " + std::to_string(number));
  const config::OperationKeys& operation = (*operations)[number - 1];
  if (operation.has_own(section) == own) return {};
  const std::string path = item(number) + "." + section;
  if (!own) return edit({{path, std::nullopt}});
  const Result<config::YamlNode> tree = config::parse_yaml(text_, file_);
  if (!tree) return tl::unexpected<Error>(tree.error());
  std::string value;
  if (const config::YamlNode* shared = shared_value(*tree, section)) value = flow_text(*shared);
  for (const config::KeyFact& fact : operation.log.facts())
    if (value.empty() && fact.path == section) value = fact.usual;
  const bool whole = section.find('.') == section.npos && !section.ends_with("_mm");
  if (value.empty() && whole) value = "{}";
  if (value.empty())
    return fail(Code::kUsage,
                section + ": the job says no value for all; state one for this operation in the text");
  return edit({{path, value}});
}

}  // namespace tiltfeed::desk
