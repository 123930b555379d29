/* Compares the sizes that docs/embedding/unity/Runtime/Palpate.cs states with the header's:
 * check_csharp Palpate.cs */
#include <stdio.h>
#include <string.h>

#include "palpate.h"

int main(int argc, char** argv) {
  static const struct {
    const char* name;
    size_t size;
  } kTypes[] = {
      {"palpate_asset", sizeof(palpate_asset)}, {"palpate_contact", sizeof(palpate_contact)},
      {"palpate_pose", sizeof(palpate_pose)},   {"palpate_tool", sizeof(palpate_tool)},
      {"palpate_input", sizeof(palpate_input)}, {"palpate_output", sizeof(palpate_output)},
      {"palpate_info", sizeof(palpate_info)},   {"palpate_mesh", sizeof(palpate_mesh)}};
  static char text[1 << 16];
  size_t i;
  int failures = 0;
  FILE* file = argc == 2 ? fopen(argv[1], "rb") : NULL;
  if (file == NULL) return 2;
  text[fread(text, 1, sizeof text - 1, file)] = 0;
  fclose(file);
  for (i = 0; i < sizeof kTypes / sizeof kTypes[0]; ++i) {
    char wanted[64];
    snprintf(wanted, sizeof wanted, "%s %u", kTypes[i].name, (unsigned)kTypes[i].size);
    if (strstr(text, wanted) != NULL) continue;
    printf("Palpate.cs does not say \"%s\"\n", wanted);
    ++failures;
  }
  return failures;
}
