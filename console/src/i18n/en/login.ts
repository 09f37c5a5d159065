export default {
  'login.title': 'Log in',
  'login.user': 'User',
  'login.password': 'Password',
  'login.show': 'Show',
  'login.hide': 'Hide',
  'login.enter': 'Log in',
  'login.checking': 'Checking…',
  'login.wait': 'Next attempt in {s} s',
  'login.user_first': 'Enter your user name',
  'login.password_first': 'Enter your password',
  'login.failed': 'The user name or the password is wrong. Each wrong attempt makes the next wait longer.',
  'login.too_often': 'Several wrong attempts were made from here. Wait, then try again.',
  'login.unreachable': 'The hub does not answer. Check the network and try again.',
  'login.capitals': 'Caps Lock is on',
  'login.ended': 'Your session has ended. Log in again: the same page will open.',
  'login.ended_all':
    'Your session has ended. STOP and LOCKOUT still work here for {n} min; for everything else log in again: the same page will open.',
  'login.ended_all_hours':
    'Your session has ended. STOP and LOCKOUT still work here for {n} h; for everything else log in again: the same page will open.',
  'login.ended_linked':
    'Your session has ended. STOP and LOCKOUT still work here as long as there is a connection to the hub; for everything else log in again: the same page will open.',
  'login.ended_stop':
    'Your session was ended by an administrator or by a new password. Only STOP still works here, for {n} min. For LOCKOUT and everything else log in again.',
  'login.ended_nothing':
    'Your session has ended. STOP does NOT work here any more: log in, or stop the monitor from another console or at its own buttons.',
  'login.silence': 'Silence the fire alarm on this page',
  'login.silenced':
    'The sound is off on this page only, and nothing is acknowledged. It returns with a new alarm that this page receives, and after you log in.',
  'login.link_used': 'This link has been used: there is an administrator already. Log in.',
};
