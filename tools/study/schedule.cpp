#include "tools/study/schedule.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr WorkKind kKinds[] = {WorkKind::prepare, WorkKind::simulate, WorkKind::merge,
                               WorkKind::finish};
constexpr double kMemoryFactor = 1.5, kMemoryBase_MB = 200;  // of a task over the pilot's
constexpr double kTimeBase_s = 120;                          // of a task's limit, for slow disks

std::string_view name_of(WorkKind kind) { return kWorkNames[static_cast<std::size_t>(kind)]; }

std::string shell_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

struct Ran {
  int status = 0;
  std::string out;  ///< and what it said on stderr
};

Ran run_line(const std::string& line) {
  Ran ran;
  std::FILE* pipe = ::popen((line + " 2>&1").c_str(), "r");
  if (!pipe) throw Error(line, "cannot be started", "Free memory and processes.");
  char part[4096];
  while (const std::size_t n = std::fread(part, 1, sizeof part, pipe)) ran.out.append(part, n);
  const int raw = ::pclose(pipe);
  ran.status = WIFEXITED(raw) ? WEXITSTATUS(raw) : 128;
  return ran;
}

// What Slurm's command prints. Throws Error with its own words where it fails.
std::string slurm(const std::string& command, const std::string& arguments) {
  const Ran ran = run_line(command + " " + arguments);
  if (ran.status == 127)
    throw Error(command, "is not there: this machine has no Slurm",
                "Log in where jobs are submitted, or use --on local or --on script.");
  if (ran.status != 0)
    throw Error(
        command, fmt::format("failed: {}", ran.out.substr(0, ran.out.find_last_not_of("\n") + 1)),
        "Nothing that is done is lost; put it right and go on with `palpate study resume`.");
  return ran.out;
}

fs::path jobs_folder(const StudyFolder& study) { return study.path() / "jobs"; }
fs::path book_path(const StudyFolder& study) { return jobs_folder(study) / "submitted.json"; }

Json book_of(const StudyFolder& study) {
  const fs::path path = book_path(study);
  if (!fs::exists(path)) return {{"rounds", 0}, {"jobs", Json::array()}};
  return Json::parse(read_whole_file(path));
}

std::string program_of(const StudyFolder& study) {
  return study.cluster().command.empty() ? shell_quoted(fs::read_symlink("/proc/self/exe").string())
                                         : study.cluster().command;
}

std::vector<std::string> lines_of(const fs::path& path) {
  std::vector<std::string> lines;
  std::istringstream text(read_whole_file(path));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> works_in(const std::string& line) {
  std::istringstream text(line);
  std::vector<std::string> works;
  for (std::string work; text >> work;) works.push_back(work);
  return works;
}

std::string batch_script(const StudyFolder& study, const WorkArray& array, const fs::path& list) {
  const ClusterSection& cluster = study.cluster();
  const double limit_s = cluster.time_factor * array.longest_s + kTimeBase_s;
  std::string text = fmt::format(
      "#!/bin/bash\n#SBATCH --job-name=palpate-{}\n#SBATCH --output={}/%x-%A_%a.log\n"
      "#SBATCH --open-mode=append\n#SBATCH --requeue\n#SBATCH --cpus-per-task=1\n"
      "#SBATCH --time={}\n#SBATCH --mem={:.0f}M\n",
      name_of(array.kind), jobs_folder(study).string(), static_cast<int>(std::ceil(limit_s / 60)),
      std::ceil(kMemoryFactor * array.most_MB + kMemoryBase_MB));
  for (const std::string& option : cluster.options) text += fmt::format("#SBATCH {}\n", option);
  return text + fmt::format("exec {} study task {} {} $((SLURM_ARRAY_TASK_ID + ${{1:-0}}))\n",
                            program_of(study), shell_quoted(study.path().string()),
                            shell_quoted(list.string()));
}

// Submits a script and books it at once, so that a later `resume` knows of it.
std::string submit_job(const StudyFolder& study, Json& book, const std::string& arguments,
                       const fs::path& list, std::size_t offset) {
  std::string id = slurm("sbatch", "--parsable " + arguments);
  id = id.substr(0, id.find_first_of(";\n"));
  book["jobs"].push_back({{"job", id}, {"list", list.string()}, {"offset", offset}});
  write_file_atomically(book_path(study), book.dump(1) + "\n");
  return id;
}

}  // namespace

std::vector<WorkArray> arrays_of(const StudyFolder& study, const std::vector<std::string>& active) {
  const std::set<std::string> excluded(active.begin(), active.end());
  const double wanted_s = 60 * study.cluster().task_min;
  std::vector<WorkArray> arrays;
  for (const WorkKind kind : kKinds) {
    WorkArray array{kind, {}, 0, 0};
    double so_far_s = 0;
    for (const Work& work : study.missing(kind)) {
      if (excluded.contains(work.text())) continue;
      const double s = study.expected_s(work);
      if (array.tasks.empty() || so_far_s + s > wanted_s) array.tasks.emplace_back(), so_far_s = 0;
      array.tasks.back().push_back(work);
      so_far_s += s;
      array.longest_s = std::max(array.longest_s, so_far_s);
      array.most_MB = std::max(array.most_MB, study.expected_MB(work));
    }
    if (!array.tasks.empty()) arrays.push_back(std::move(array));
  }
  return arrays;
}

fs::path write_list(const StudyFolder& study, const WorkArray& array) {
  fs::create_directories(jobs_folder(study));
  int number = 1;
  fs::path path;
  const auto named = [&](int n, WorkKind kind) {
    return jobs_folder(study) / fmt::format("{:03}-{}.txt", n, name_of(kind));
  };
  const auto is_taken = [&](int n) {
    return std::any_of(std::begin(kKinds), std::end(kKinds),
                       [&](WorkKind kind) { return fs::exists(named(n, kind)); });
  };
  while (is_taken(number)) ++number;
  path = named(number, array.kind);
  std::string text;
  for (const auto& task : array.tasks) {
    std::vector<std::string> works;
    for (const Work& work : task) works.push_back(work.text());
    text += fmt::format("{}\n", fmt::join(works, " "));
  }
  write_file_atomically(path, text);
  return path;
}

int do_task(const StudyFolder& study, const fs::path& list, int line, int jobs) {
  const std::vector<std::string> lines = lines_of(list);
  if (line < 1 || line > static_cast<int>(lines.size()))
    throw Error(list.string(), fmt::format("has {} tasks, no task {}", lines.size(), line),
                "Number tasks from 1.");
  int failed = 0;
  for (const std::string& work : works_in(lines[static_cast<std::size_t>(line - 1)]))
    failed += !study.work(Work::parse(work), jobs);
  return failed;
}

int do_all(const StudyFolder& study, int jobs) {
  int failed = 0;
  std::set<std::string> tried;  // not twice what fails
  const auto all = [&](WorkKind kind) {
    int done = 0;
    for (const Work& work : study.missing(kind)) {
      const std::string name = fmt::format("{} {}", work.text(), study.rounds());
      if (study.state(work.item) == CaseState::failed && kind != WorkKind::prepare) continue;
      if (!tried.insert(name).second) continue;
      const bool is_done = study.work(work, jobs);
      failed += !is_done;
      done += is_done;
    }
    return done;
  };
  all(WorkKind::prepare);
  while (all(WorkKind::simulate) + all(WorkKind::merge) > 0) {
  }
  all(WorkKind::finish);
  return failed;
}

std::string script_of(const StudyFolder& study) {
  std::string text =
      "# Run each block on any machines that share this folder, after the one before it.\n";
  for (const WorkArray& array : arrays_of(study, {})) {
    const fs::path list = write_list(study, array);
    text += fmt::format(
        "# {}: {} tasks, {} each at most on one processor, {:.0f} MB\n"
        "for task in $(seq 1 {}); do {} study task {} {} $task --jobs 1; done\n",
        name_of(array.kind), array.tasks.size(), in_words(array.longest_s),
        std::ceil(kMemoryFactor * array.most_MB + kMemoryBase_MB), array.tasks.size(),
        program_of(study), shell_quoted(study.path().string()), shell_quoted(list.string()));
  }
  if (study.has_rounds())
    text += "# Points place themselves: print and run this again until nothing is left.\n";
  return text +
         fmt::format("{} study status {}", program_of(study), shell_quoted(study.path().string()));
}

bool was_submitted(const StudyFolder& study) { return fs::exists(book_path(study)); }

SlurmQueue queue_of(const StudyFolder& study) {
  SlurmQueue queue;
  if (!was_submitted(study)) return queue;
  const Json book = book_of(study);
  std::map<std::string, std::pair<fs::path, std::size_t>> jobs;
  for (const Json& job : book.at("jobs"))
    jobs[job.at("job")] = {job.at("list").get<std::string>(), job.at("offset")};
  std::map<fs::path, std::vector<std::string>> lists;
  std::istringstream rows(slurm("squeue", "--noheader --array --format='%F %K %t'"));
  std::string id, index, state;
  while (rows >> id >> index >> state) {
    const auto found = jobs.find(id);
    if (found == jobs.end()) continue;
    const bool is_running = state == "R" || state == "CG" || state == "CF";
    ++(is_running ? queue.running : queue.pending);
    const auto& [list, offset] = found->second;
    if (list.empty() || index == "N/A") continue;
    if (!lists.contains(list)) lists[list] = lines_of(list);
    const std::size_t line = std::stoul(index) + offset;
    if (line < 1 || line > lists[list].size()) continue;
    for (const std::string& work : works_in(lists[list][line - 1])) queue.active.push_back(work);
  }
  return queue;
}

int submit(const StudyFolder& study, bool only_rounds) {
  fs::create_directories(jobs_folder(study));
  Json book = book_of(study);
  if (only_rounds && study.rounds() <= book.value("rounds", 0)) return 0;
  const SlurmQueue queue = queue_of(study);
  book["rounds"] = study.rounds();
  std::vector<std::string> before;
  int tasks = 0;
  const auto dependency = [&] {
    return before.empty() ? "" : fmt::format("--dependency=afterany:{} ", fmt::join(before, ":"));
  };
  for (const WorkArray& array : arrays_of(study, queue.active)) {
    const fs::path list = write_list(study, array);
    const fs::path script = fs::path(list).replace_extension(".sh");
    write_file_atomically(script, batch_script(study, array, list));
    const auto most = static_cast<std::size_t>(study.cluster().max_array);
    std::vector<std::string> ids;
    for (std::size_t offset = 0; offset < array.tasks.size(); offset += most) {
      const std::size_t count = std::min(most, array.tasks.size() - offset);
      ids.push_back(submit_job(study, book,
                               fmt::format("{}--array=1-{} {} {}", dependency(), count,
                                           shell_quoted(script.string()), offset),
                               list, offset));
    }
    say("slurm: {} {} tasks, {} each at most: job {}", array.tasks.size(), name_of(array.kind),
        in_words(array.longest_s), listed(ids));
    tasks += static_cast<int>(array.tasks.size());
    before = std::move(ids);
  }
  if (study.has_rounds() && !before.empty()) {
    const std::string line =
        fmt::format("{} study next {}", program_of(study), shell_quoted(study.path().string()));
    submit_job(
        study, book,
        fmt::format("{}--job-name=palpate-next --output={}/%x-%j.log --time=30 --wrap={}",
                    dependency(), shell_quoted(jobs_folder(study).string()), shell_quoted(line)),
        "", 0);
  }
  return tasks;
}

}  // namespace palpate::tools
