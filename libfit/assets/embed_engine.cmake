# Writes a source file that holds the text of the engine's files: cmake -DOUT= -DDIR= -DFILES= -P this
set(text "#include \"libfit/assets/exporters.hpp\"\n\nnamespace palpate {\nnamespace {\n\nconstexpr EngineFile kFiles[] = {\n")
foreach(name ${FILES})
  file(READ "${DIR}/${name}" content)
  string(APPEND text "    {\"${name}\", R\"=palpate=(${content})=palpate=\"},\n")
endforeach()
string(APPEND text "};\n\n}  // namespace\n\nstd::span<const EngineFile> engine_files() { return kFiles; }\n\n}  // namespace palpate\n")
file(WRITE "${OUT}" "${text}")
