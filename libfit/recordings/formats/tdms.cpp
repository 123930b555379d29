// Recordings of LabVIEW's TDMS: a group of channels is one.

#include <algorithm>
#include <utility>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "libfit/recordings/formats/tdms_file.hpp"

namespace palpate::importers {
namespace {

using TdmsGroup = std::vector<const TdmsChannel*>;

// Channels with numbers, by their group; all in one where columns are named "Group/Channel".
std::vector<std::pair<std::string, TdmsGroup>> groups_of(const TdmsFile& file, bool is_whole) {
  std::vector<std::pair<std::string, TdmsGroup>> groups;
  for (const TdmsChannel& channel : file.channels()) {
    if (channel.blocks.empty()) continue;
    const std::string name = is_whole ? "" : channel.group;
    auto found = std::ranges::find(groups, name, &std::pair<std::string, TdmsGroup>::first);
    if (found == groups.end()) found = groups.insert(groups.end(), {name, {}});
    found->second.push_back(&channel);
  }
  return groups;
}

bool names_group(const ColumnNames& names) {
  return std::ranges::any_of(
      roles_of(names), [](const Role& role) { return role.name.find('/') != std::string::npos; });
}

// Whether a group has a channel that is named, or channels that name themselves.
bool offers_columns(const TdmsGroup& group, const ColumnNames& names) {
  std::vector<std::string> header;
  for (const TdmsChannel* c : group) header.push_back(c->header());
  const auto roles = roles_of(names);
  if (roles.empty()) return !columns_named(header).columns.force.empty();
  return std::ranges::any_of(roles, [&](const Role& role) {
    return std::ranges::any_of(header, [&](const std::string& of) {
      return split_unit(of).first == split_unit(role.name).first;
    });
  });
}

RawRecording recording_of(const std::filesystem::path& path, const TdmsFile& file,
                          const TdmsGroup& group, bool is_whole, const ReadSettings& given) {
  const auto fail_at = [&](const std::string& name) {
    return [&path, name](const std::string& what, const std::string& remedy) {
      return Error(path.string() + (name.empty() ? "" : ":" + name), what, remedy);
    };
  };
  std::vector<std::string> header;
  for (const TdmsChannel* c : group)
    header.push_back((is_whole ? c->group + "/" : "") + c->header());
  std::string taken;
  const ReadSettings settings = with_named_columns(given, header, fail_at(""), taken);
  const auto roles = roles_of(settings.columns);
  if (roles.empty())
    throw fail_at("")("no channel is named",
                      "Name columns = { depth = ..., force = ... } in the manifest. There are: " +
                          listed(header) + ".");
  const auto fields = find_columns(roles, header, fail_at(""));
  std::vector<std::vector<double>> columns;
  std::vector<double> factors;
  double step_s = group[fields[0]]->step_s;
  for (std::size_t k = 0; k < roles.size(); ++k) {
    const TdmsChannel& channel = *group[fields[k]];
    columns.push_back(file.values(channel));
    factors.push_back(channel.is_of_times() ? 1
                                            : factor_of(roles[k], header[fields[k]], settings.units,
                                                        fail_at(roles[k].name)));
    if (channel.step_s != step_s) step_s = 0;
  }
  RawRecording r = recording_of_arrays(
      roles, std::move(columns), factors, settings,
      [&](const Role& role, const std::string& what, const std::string& remedy) {
        return fail_at(role.name)(what, remedy);
      });
  if (!taken.empty()) r.taken.push_back(taken);
  if (r.time_s.empty() && settings.columns.retract_depth.empty() && step_s > 0 && step_s < 1e6) {
    for (const std::size_t line : r.line)
      r.time_s.push_back(step_s * static_cast<double>(line - 1));
    r.taken.push_back("readings every " + number(step_s) + " s");
  }
  if (file.is_cut_short()) r.taken.push_back("the file is cut short: what is whole was read");
  return r;
}

}  // namespace

bool begins_tdms(std::string_view head) { return head.starts_with("TDSm"); }

std::vector<RawRecording> read_tdms(const std::filesystem::path& path, std::string_view bytes,
                                    const ReadSettings& settings) {
  if (!begins_tdms(bytes))
    throw Error(path.string(), "is no TDMS file", "Name the file with the data, not its index.");
  const TdmsFile file(path, bytes);
  const bool is_whole = names_group(settings.columns);
  const auto groups = groups_of(file, is_whole);
  if (groups.empty())
    throw Error(path.string(), "has no channel with numbers", "Record it again, or leave it out.");
  if (groups.size() == 1) return {recording_of(path, file, groups[0].second, is_whole, settings)};
  std::vector<RawRecording> out;
  for (const auto& [name, group] : groups) {
    if (!offers_columns(group, settings.columns)) continue;  // settings, notes
    RawRecording r;
    try {
      r = recording_of(path, file, group, is_whole, settings);
    } catch (const Error& error) {
      r.unread = error;
    }
    r.name = name;
    out.push_back(std::move(r));
  }
  if (out.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, group] : groups)
      for (const TdmsChannel* c : group) names.push_back(name + "/" + c->header());
    throw Error(path.string(), "has no group with the channels that are wanted",
                "Name columns = { depth = ..., force = ... } in the manifest. There are: " +
                    listed(names).substr(0, 300) + ".");
  }
  return out;
}

}  // namespace palpate::importers
