#compdef terrazzo
# Zsh completion for terrazzo, printed by `terrazzo completion zsh`. The program finds the candidates.
_terrazzo() {
  local -a typed found open
  typed=("${(@Q)words[1,CURRENT-1]}" "${(Q)PREFIX}")
  typed=("${(@)typed/#\~\//$HOME/}")
  found=("${(@f)$("${typed[1]}" complete -- "${(@)typed[2,-1]}" 2>/dev/null)}")
  open=(${(M)found:#*[=/]})
  found=(${found:#*[=/]})
  [[ $PREFIX == \~/* ]] && local -a replace=(-U)
  compadd $replace -S '' -a open
  compadd $replace -a found
  (($#open + $#found))  # whether there are any
}
if [[ $funcstack[1] == _terrazzo ]]; then _terrazzo "$@"; else compdef _terrazzo terrazzo; fi
