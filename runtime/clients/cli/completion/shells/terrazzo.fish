# Fish completion for terrazzo, printed by `terrazzo completion fish`. The program finds the candidates.
function __terrazzo_complete
    set -l words (commandline -opc) (commandline -ct | string unescape)
    set words (string replace -r '^~/' "$HOME/" -- $words)
    $words[1] complete -- $words[2..-1] 2>/dev/null
end
complete -c terrazzo -f -a '(__terrazzo_complete)'
