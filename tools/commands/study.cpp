#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/study/study_folder.hpp"

namespace palpate::tools {
namespace {

constexpr NamedOutput kFiles[] = {{"study.json", "{\"schema\":\"palpate-study\""},
                                  {"results.csv", "case,state,"}};

std::string shell_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// A job array for Slurm with an element a task. Other schedulers set SLURM_ARRAY_TASK_ID.
std::string array_script(const StudyFolder& study, const std::vector<int>& tasks) {
  const ClusterSection& cluster = study.cluster();
  std::string text = fmt::format(
      "#!/bin/bash\n#SBATCH --job-name=palpate\n#SBATCH --array={}\n#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n#SBATCH --output={}/task-%a.log\n",
      fmt::join(tasks, ","), study.path().string());
  for (const std::string& option : cluster.options) text += fmt::format("#SBATCH {}\n", option);
  const std::string program =
      cluster.command.empty()
          ? shell_quoted(std::filesystem::read_symlink("/proc/self/exe").string())
          : cluster.command;
  return text + fmt::format("exec {} study task {} $SLURM_ARRAY_TASK_ID --jobs {}", program,
                            shell_quoted(study.path().string()), "${SLURM_CPUS_PER_TASK:-1}");
}

// Throws Error where there is no Slurm, or it refuses.
void submit(const StudyFolder& study, const std::string& script) {
  const std::filesystem::path path = study.path() / "array.sh";
  write_file_atomically(path, script + "\n");
  const int status = std::system(fmt::format("sbatch {} >&2", shell_quoted(path.string())).c_str());
  if (WEXITSTATUS(status) == 127)
    throw Error("sbatch", "is not there: this machine has no Slurm",
                "Log in where jobs are submitted, or use --on local or --on script.");
  if (status != 0)
    throw Error(
        "sbatch", "refuses " + path.string(),
        "Nothing that is done is lost; put it right and go on with `palpate study resume`.");
}

class StudyCommand final : public Command {
 public:
  explicit StudyCommand(Arguments& arguments) {
    arguments.positionals("study", words_,
                          "Study to plan and run, STUDY.toml; or status DIR: how far it is; or "
                          "resume DIR: run only what is missing");
    arguments.option("-o,--output DIR", folder_, "Folder for all files of the study");
    arguments.named_outputs(folder_, kFiles);
    arguments.option("--on WHERE", on_,
                     "Where it runs: local (this process; the default), slurm (submits a job "
                     "array), or script (prints that array's script)");
    arguments.jobs(jobs_);
  }

  int run(Reply& reply) override {
    if (!on_.empty() && on_ != "local" && on_ != "slurm" && on_ != "script")
      throw Error("--on", fmt::format("\"{}\" is not known", on_), "Use local, slurm or script.");
    const std::string& what = words_.front();
    if (words_.size() == 2 && what == "status") return status(StudyFolder(words_[1]), reply);
    if (words_.size() == 2 && what == "resume") return resume(reply);
    if (words_.size() == 3 && what == "task") {
      const StudyFolder study(words_[1]);
      const int task = std::atoi(words_[2].c_str());
      if (task < 0 || task >= static_cast<int>(study.cases().size()))
        throw Error(words_[2], "is no case of the study", "Number them from 0 on.");
      study.run_case(task, jobs_);
      return study.state(task) == CaseState::done ? kDone : kSomeFailed;
    }
    if (words_.size() != 1)
      throw Error(listed(words_, " "), "is neither a study nor something to do with one",
                  "Give STUDY.toml -o DIR, or status DIR, or resume DIR.");
    if (folder_.empty()) throw Error("-o", "is missing", "Name a folder for the study's files.");
    const Study study = read_study(what);
    StudyFolder::plan(folder_, study);
    say("{} cases", study.cases.size());
    return start(on_.empty() ? "local" : on_, reply);
  }

 private:
  int resume(Reply& reply) {
    folder_ = words_[1];
    const StudyFolder study(folder_);
    study.forget_failures();
    return start(on_.empty() ? "local" : on_, reply);
  }

  int start(const std::string& on, Reply& reply) {
    const StudyFolder study(folder_);
    const std::vector<int> tasks = study.missing();
    if (on == "local") {
      for (const int task : tasks) study.run_case(task, jobs_);
      return status(study, reply);
    }
    reply.json = nlohmann::ordered_json{{"tasks", tasks.size()}};
    const std::string script = array_script(study, tasks);
    if (on == "script")
      reply.json["script"] = reply.text = script;
    else if (!tasks.empty())
      submit(study, script);
    return kDone;
  }

  int status(const StudyFolder& study, Reply& reply) {
    study.write_results();
    std::array<int, kCaseStateNames.size()> count{};
    std::size_t listed_failures = 0;
    const auto cases = static_cast<int>(study.cases().size());
    for (int i = 0; i < cases; ++i) {
      ++count[static_cast<std::size_t>(study.state(i))];
      if (const std::string failure = study.failure(i); !failure.empty() && ++listed_failures <= 15)
        say_failed("case {} ({}): {}", i + 1, listed(study.cases()[i].inputs), failure);
    }
    reply.json = nlohmann::ordered_json{{"cases", cases}};
    std::string states;
    for (std::size_t state = 0; state < count.size(); ++state) {
      reply.json[std::string(kCaseStateNames[state])] = count[state];
      if (count[state] > 0)
        states += fmt::format("{}{} {}", states.empty() ? "" : ", ", count[state],
                              kCaseStateNames[state]);
    }
    reply.text = fmt::format("{} cases: {}; {} lists them", cases, states,
                             (study.path() / "results.csv").string());
    if (count[0] < cases)
      reply.text +=
          fmt::format("\n`palpate study resume {}` runs what is missing", study.path().string());
    return count[static_cast<std::size_t>(CaseState::failed)] ? kSomeFailed : kDone;
  }

  std::vector<std::string> words_;
  std::string folder_, on_;
  int jobs_ = 0;
};

}  // namespace

const CommandRow kStudyCommand{
    "study", "Run many scenes: bodies, materials, probes and settings, here or on a cluster",
    declared<StudyCommand>, "Studies", "study study.toml -o out"};

}  // namespace palpate::tools
