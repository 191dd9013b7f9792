# Bash completion for terrazzo, printed by `terrazzo completion bash`. The program finds the candidates.
_terrazzo() {
  local line=${COMP_LINE:-${COMP_WORDS[*]}} words=() word head i
  local typed=${COMP_WORDS[COMP_CWORD]} breaks=${COMP_WORDBREAKS//[^=:]/}
  line=${line:0:${COMP_POINT:-${#line}}}
  for ((i = 0; i <= COMP_CWORD; i++)); do
    # Bash also splits at = and :, so join the parts that no space separates.
    word=${line%%[![:space:]]*}
    if ((i == 0)) || [[ $word ]]; then words+=(""); fi
    line=${line#"$word"} word=${COMP_WORDS[i]}
    ((i == COMP_CWORD)) && word=$line  # without what follows the cursor
    words[-1]+=$word line=${line#"$word"}
  done
  for i in "${!words[@]}"; do
    IFS= read word <<<"${words[i]}"  # removes backslashes
    word=${word//[\"\']/}
    words[i]=${word/#\~\//$HOME/}
  done
  mapfile -t COMPREPLY < <("${words[0]}" complete -- "${words[@]:1}" 2>/dev/null)
  # Bash replaces only what follows the last = or :.
  if [[ $breaks ]]; then head=${words[-1]} head=${head%"${head##*[$breaks]}"}; fi
  [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *[=/] ]] && compopt -o nospace 2>/dev/null
  for i in "${!COMPREPLY[@]}"; do
    word=${COMPREPLY[i]#"$head"}
    if [[ $typed != [\"\']* && $word == *[[:space:]\"\'\\\$\`\&\;\|\<\>\(\)\*\?!#]* ]]; then printf -v word %q "$word"; fi
    COMPREPLY[i]=$word
  done
}
complete -F _terrazzo terrazzo
