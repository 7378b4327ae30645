#include "daemon/post/nc_planes.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include "kinematics/machine/spindle_frame.h"

namespace tiltfeed::daemon {
namespace {

tl::unexpected<Error> no_plane(const std::string& what) { return fail(Code::kInput, what); }

/// The numbers between the brackets, the second of them a name in quotes.
bool listed(const std::string& line, std::vector<double>& numbers, std::string& name) {
  std::string text = line.substr(line.find('(') + 1);
  if (text.empty() || text.back() != ')') return false;
  text.pop_back();
  std::istringstream in(text);
  for (std::string one; std::getline(in, one, ',');) {
    double value = 0.0;
    std::istringstream number(one);
    if (numbers.size() == 1)
      name = one;
    else if (!(number >> value))
      return false;
    numbers.push_back(value);
  }
  return true;
}

Result<TextPlane> swivel(const std::string& line, const std::string& wanted) {
  std::vector<double> v;
  std::string name;
  if (!listed(line, v, name) || v.size() != 15) return no_plane("CYCLE800 is not understood");
  if (!wanted.empty() && name != "\"" + wanted + "\"")
    return no_plane("CYCLE800 calls the swivel data " + name + ", the profile's program.swivel_data is \"" +
                    wanted + "\"; read it with the profile of its machine");
  const bool plain = v[0] == 0.0 && v[2] == 0.0 && v[3] == 27.0 && v[10] == 0.0 && v[11] == 0.0 &&
                     v[12] == 0.0 && v[14] == 0.0;
  if (!plain)
    return no_plane("CYCLE800 is understood in mode 27 alone, without a retract and a second shift");
  return TextPlane{from_zyx({v[7], v[8], v[9]}), {v[4], v[5], v[6]}};
}

Result<TextPlane> spatial(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  const bool stays = words.size() == 9 && words[5] == "STAY" && words[7] == "TABLE" && words[8] == "ROT";
  if (!stays) return no_plane("PLANE SPATIAL is understood with STAY, SEQ and TABLE ROT alone");
  PlaneAngles angles{};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const std::string& word = words[2 + i];
    const std::string name = std::string("SP") + static_cast<char>('A' + i);
    double& angle = angles[angles.size() - 1 - i];
    if (word.rfind(name, 0) != 0 || !(std::istringstream(word.substr(name.size())) >> angle))
      return no_plane("PLANE SPATIAL wants " + name + " with an angle");
  }
  return TextPlane{from_zyx(angles), {}};
}

}  // namespace

Result<TextPlane> plane_of_words(const DialectWords& words) {
  for (const char letter : {'X', 'Y', 'Z', 'I', 'J', 'K'})
    if (!words.has(letter)) return no_plane(std::string("G68.2 wants ") + letter);
  if (words.values.size() > 6 || words.g.size() > 1)
    return no_plane("G68.2 stands with other words; let it stand alone");
  const auto at = [&](char letter) { return words.values.at(letter); };
  return TextPlane{from_zxz({at('I'), at('J'), at('K')}), {at('X'), at('Y'), at('Z')}};
}

Result<TextPlane> plane_of_line(const std::string& line, const std::string& swivel_data) {
  return line.rfind("CYCLE800", 0) == 0 ? swivel(line, swivel_data) : spatial(line);
}

}  // namespace tiltfeed::daemon
